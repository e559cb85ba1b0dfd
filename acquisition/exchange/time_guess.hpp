// SPDX-License-Identifier: Apache-2.0
/// Guesses which columns of a table have the times of its rows, and in which notation.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/table_sample.hpp"

namespace gyrotherm::exchange {

/// The [time] of a first map.
struct TimeGuess {
  std::string text{};                  ///< with its head
  std::vector<std::size_t> columns{};  ///< used, or doubtful
};

/// Guesses by the names of columns, by the notation of their texts, and by the steps of their numbers. If two readings
/// are equally likely, or a column looks like a date of an unknown notation, a key is missing in the map: no import
/// runs before people have decided. `thermometers` are columns of temperatures; their pace distinguishes seconds from
/// milliseconds.
[[nodiscard]] TimeGuess guess_time(const TableSample& sample, const std::vector<std::size_t>& thermometers);

}  // namespace gyrotherm::exchange
