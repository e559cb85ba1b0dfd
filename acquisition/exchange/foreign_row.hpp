// SPDX-License-Identifier: Apache-2.0
/// The results of the readers of files of other programs.
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

/// One row of a file of another program.
struct ForeignRow {
  /// The time since the first row; in a log, the time since the logging machine started.
  Duration time{};
  /// UTC, if the file has it.
  std::optional<Duration> utc{};
  /// The numbers of the file, one per column of ImportMap::columns(); NaN if missing.
  std::span<const double> numbers{};
};

/// Takes the rows in order of the file. A fault without a position concerns the row itself; the reader adds its
/// position.
using TakeRow = std::function<Result<void>(const ForeignRow& row)>;

/// Messages about skipped or suspicious content, which the record stores as events.
using Notes = std::vector<std::string>;

/// Counts of the texts that marked missing values in a column.
using MissingTexts = std::map<std::string, std::size_t>;

/// The observations of a reader about a whole file.
struct Findings {
  Notes notes{};
  std::vector<MissingTexts> missing{};  ///< per column of ImportMap::columns()
  /// The number of unreadable lines.
  std::size_t lines_left_out{};
  /// A time column that the map does not use, and its possible durations, one per notation.
  std::string other_clock{};
  std::vector<Duration> other_spans{};
  /// The period of that column, of which the durations are known only modulo this period; 0 if it has none.
  Duration other_period{};
};

}  // namespace gyrotherm::exchange
