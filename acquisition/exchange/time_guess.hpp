// SPDX-License-Identifier: Apache-2.0
/// Detects the columns of a table that contain the times of its rows, and their notation.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/table_sample.hpp"

namespace gyrotherm::exchange {

/// The section [time] of a draft map.
struct TimeGuess {
  std::string text{};                  ///< including the section header
  std::vector<std::size_t> columns{};  ///< used or possible time columns
};

/// Detects the time from the names of columns, the notation of their texts, and the steps of their numbers. If two
/// interpretations are equally likely, or a column looks like a date in an unknown notation, it omits a key. An import
/// then fails until the user has decided. `thermometers` are the columns of temperatures, whose rate of change
/// distinguishes seconds from milliseconds.
[[nodiscard]] TimeGuess guess_time(const TableSample& sample, const std::vector<std::size_t>& thermometers);

}  // namespace gyrotherm::exchange
