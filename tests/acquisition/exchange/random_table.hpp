// SPDX-License-Identifier: Apache-2.0
/// Tables as laboratories write them, drawn at random, with what they mean.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gyrotherm::exchange {

struct RandomTable {
  std::string text{};
  std::string drawn{};  ///< what was drawn, in words
  /// The rows that can be read.
  std::vector<double> time_s{};                        ///< since the first
  std::vector<std::vector<double>> temperatures_c{};   ///< per thermometer; NaN where the cell has a marker
  std::vector<std::vector<double>> rates_deg_per_h{};  ///< per axis
  std::optional<double> started_utc_s{};               ///< where the file says it
  std::size_t damaged{};                               ///< lines that cannot be read
};

[[nodiscard]] RandomTable random_table(std::uint64_t seed);

}  // namespace gyrotherm::exchange
