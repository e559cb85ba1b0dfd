// SPDX-License-Identifier: Apache-2.0
/// Generates random tables in the notations of laboratories, with their meaning.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gyrotherm::exchange {

struct RandomTable {
  std::string text{};
  /// Describes the random choices.
  std::string drawn{};
  /// The content of the readable rows: times since the first row, temperatures per thermometer (NaN for a marker of a
  /// missing value), and rates per axis.
  std::vector<double> time_s{};
  std::vector<std::vector<double>> temperatures_c{};
  std::vector<std::vector<double>> rates_deg_per_h{};
  /// The time of the first row, if the file has it.
  std::optional<double> started_utc_s{};
  /// The number of unreadable lines.
  std::size_t damaged{};
  /// The same table with more unreadable lines before and among its first rows, and the number of all its unreadable
  /// lines. Some of the lines have the time of a much later row.
  std::string damaged_text{};
  std::size_t damaged_in_text{};
};

[[nodiscard]] RandomTable random_table(std::uint64_t seed);

}  // namespace gyrotherm::exchange
