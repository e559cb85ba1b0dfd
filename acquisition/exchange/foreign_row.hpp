// SPDX-License-Identifier: Apache-2.0
/// What the readers of foreign files hand on.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// What a foreign file says of one instant.
struct ForeignRow {
  Duration time{};                    ///< since the first row; of a log, since its machine was started
  std::optional<Duration> utc{};      ///< where the file knows it
  std::span<const double> numbers{};  ///< as in the file, per column of ImportMap::columns(); NaN where there is none
};

/// Takes the rows in order of the file. A fault without a place is one of the row itself, whose place its reader knows.
using TakeRow = std::function<Result<void>(const ForeignRow& row)>;

/// What a reader had to pass over, in sentences for the record; empty: nothing.
using Notes = std::vector<std::string>;

/// Counts of the texts that marked missing values in a column.
using MissingTexts = std::map<std::string, std::size_t>;

/// Findings of a reader about a whole file.
struct Findings {
  Notes notes{};
  std::vector<MissingTexts> missing{};  ///< per column of ImportMap::columns()
  std::size_t lines_left_out{};         ///< unreadable lines
  std::string other_clock{};            ///< a time column the map does not use
  std::vector<Duration> other_spans{};  ///< its durations, one per reading
};

}  // namespace gyrotherm::exchange
