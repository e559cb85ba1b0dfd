// SPDX-License-Identifier: Apache-2.0
/// How rows of a foreign file become rows of a record: in order of time, each with the interval that it covers, and, if
/// the map says so, put together into one for each stretch.
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
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// The usual step between neighbours, their median; 0 where there are none.
template <class T>
[[nodiscard]] T usual_step(const std::vector<T>& numbers) {
  std::vector<T> steps;
  for (std::size_t i = 1; i < numbers.size(); ++i) steps.push_back(numbers[i] - numbers[i - 1]);
  if (steps.empty()) return {};
  const auto middle = steps.begin() + std::ssize(steps) / 2;
  std::ranges::nth_element(steps, middle);
  return *middle;
}

/// A longer time without a row than so many usual steps is a gap, where a record keeps its own times.
inline constexpr int kUsualStepsOfASilence = 10;

/// A row as the record gets it.
struct ImportedRow {
  Duration time{};                    ///< since the first row
  std::optional<Duration> utc{};      ///< where the file knows it
  Duration interval{};                ///< what a gyro's number covers
  Duration usual{};                   ///< the spacing of rows that nothing is missing between
  std::span<const double> numbers{};  ///< per column of ImportMap::columns(); NaN where there is none
};
using TakeImported = std::function<Result<void>(const ImportedRow& row)>;

/// Checks that rows come in order of time, and knows what interval each covers: the map's; or, where rows have times of
/// their own, the usual spacing for a rate, and for an increment the time since the row before (of the first row: the
/// usual spacing). The usual spacing is the median of the first 65,535 (of rows of many columns fewer), which are held
/// back until it is known.
class Spacing {
 public:
  Spacing(const ImportMap& map, TakeImported take) : map_(map), take_(std::move(take)), usual_(map.interval) {}

  /// Fails with bad_file and no place where the time does not increase, unless it stands still and rows are put
  /// together; or as `take` does.
  [[nodiscard]] Result<void> push(const ForeignRow& row);
  /// Hands on what is held back.
  [[nodiscard]] Result<void> finish();

 private:
  [[nodiscard]] Result<void> hand_on(const ForeignRow& row, std::optional<Duration> since_before);
  void hold_back(const ForeignRow& row);

  const ImportMap& map_;
  TakeImported take_;
  Duration usual_{};  ///< 0: not known yet
  std::optional<Duration> first_{}, last_{};
  std::vector<Duration> times_{};  ///< of the rows held back
  std::vector<std::optional<Duration>> utcs_{};
  std::vector<double> numbers_{};
};

/// Puts all rows of a stretch of ImportMap::every together: temperatures, rates and values are the means of what was
/// there, increments are added, with their intervals. A stretch without rows makes none.
class Grouping {
 public:
  Grouping(const ImportMap& map, TakeImported take);

  /// Rows may be late by a stretch, those of a log by 5 s. Fails as Spacing::push() does where one is later.
  [[nodiscard]] Result<void> push(const ImportedRow& row);
  [[nodiscard]] Result<void> finish();
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

 private:
  struct Stretch {
    std::int64_t number{};
    Duration interval{};
    std::optional<Duration> utc{};  ///< of its beginning
    std::vector<double> sums{};
    std::vector<std::int64_t> counts{};
  };
  Stretch& stretch_at(std::deque<Stretch>::iterator place, std::int64_t number);
  void add(Stretch& stretch, const ImportedRow& row) const;
  [[nodiscard]] Result<void> hand_on_first();
  [[nodiscard]] bool is_increment(std::size_t column) const { return column >= first_sum_ && column < end_of_sums_; }

  const ImportMap& map_;
  TakeImported take_;
  std::size_t columns_{};
  std::size_t first_sum_{}, end_of_sums_{};  ///< the columns that are increments
  std::size_t most_open_{};
  std::deque<Stretch> open_{};           ///< in order of their numbers
  std::optional<std::int64_t> first_{};  ///< that was handed on
  std::int64_t handed_on_{};             ///< the last
  std::size_t left_out_{};
};

}  // namespace gyrotherm::exchange
