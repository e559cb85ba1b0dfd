// SPDX-License-Identifier: Apache-2.0
/// Converts the rows of a file of another program to rows of a record: in order of time, each with the interval that it
/// covers, and optionally combined into one row per stretch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/increment_columns.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Returns the median step between consecutive numbers; 0 if there are fewer than two numbers.
template <class T>
[[nodiscard]] T usual_step(const std::vector<T>& numbers) {
  std::vector<T> steps;
  for (std::size_t i = 1; i < numbers.size(); ++i) steps.push_back(numbers[i] - numbers[i - 1]);
  if (steps.empty()) return {};
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::ranges::nth_element(steps, middle);
  return *middle;
}

/// In an imported record, a time without rows is a gap if it exceeds this number of usual spacings.
inline constexpr int kGapInUsualSteps = 10;

/// A row for the record.
struct ImportedRow {
  /// The time since the first row.
  Duration time{};
  /// UTC, if the file has it.
  std::optional<Duration> utc{};
  /// The interval that a gyro's number covers, unless the row contains its counting time.
  Duration interval{};
  /// The spacing of rows without gaps.
  Duration usual{};
  /// One number per column of ImportMap::columns(); NaN if missing.
  std::span<const double> numbers{};
};
using TakeImported = std::function<Result<void>(const ImportedRow& row)>;

/// Checks that rows are in order of time, and determines the interval of each row. If the map states an interval, it
/// applies to every row. Otherwise the interval of a rate is the usual spacing, and the interval of an increment is the
/// time since the row before; in the first row both are the usual spacing. The usual spacing is the median over the
/// first 65,536 rows (fewer if they have many columns). These rows are held back until the spacing is known.
class Spacing {
 public:
  Spacing(const ImportMap& map, TakeImported take) : map_(map), take_(std::move(take)), usual_(map.interval) {}

  /// Fails with bad_file, without a position, if the time does not increase. Equal times are allowed if rows are
  /// combined. Fails as `take` does.
  [[nodiscard]] Result<void> push(const ForeignRow& row);
  /// Passes on the rows that are held back.
  [[nodiscard]] Result<void> finish();

 private:
  [[nodiscard]] Result<void> pass_on(const ForeignRow& row, std::optional<Duration> since_before);
  void hold_back(const ForeignRow& row);

  const ImportMap& map_;
  TakeImported take_;
  Duration usual_{};  ///< 0: unknown so far
  std::optional<Duration> first_{}, last_{};
  /// The times, UTC and numbers of the rows held back.
  std::vector<Duration> times_{};
  std::vector<std::optional<Duration>> utcs_{};
  std::vector<double> numbers_{};
};

/// Combines all rows of a stretch of ImportMap::every. Takes the means of the available temperatures, rates and values,
/// and the sums of increments, their intervals and their counting times. A row without a counting time is not part of
/// the sums. A stretch without rows produces no row.
class Grouping {
 public:
  Grouping(const ImportMap& map, TakeImported take);

  /// Adds a row. A row may be late by one stretch, or by 5 s in a log. For a later row, fails as Spacing::push() does.
  [[nodiscard]] Result<void> push(const ImportedRow& row);
  [[nodiscard]] Result<void> finish();
  [[nodiscard]] std::size_t skipped_rows() const { return left_out_; }

 private:
  struct Stretch {
    std::int64_t number{};
    Duration interval{};
    std::optional<Duration> utc{};  ///< start of the stretch
    std::vector<double> sums{};
    std::vector<std::int64_t> counts{};
  };
  Stretch& stretch_at(const std::deque<Stretch>::iterator& position, std::int64_t number);
  void add(Stretch& stretch, const ImportedRow& row) const;
  [[nodiscard]] Result<void> pass_on_first();

  const ImportMap& map_;
  TakeImported take_;
  std::size_t columns_{};
  IncrementColumns increments_;
  std::size_t most_open_{};
  /// Open stretches, in order of their numbers.
  std::deque<Stretch> open_{};
  /// The numbers of the first and of the last stretch passed on.
  std::optional<std::int64_t> first_{};
  std::int64_t passed_on_{};
  std::size_t left_out_{};
};

}  // namespace gyrotherm::exchange
