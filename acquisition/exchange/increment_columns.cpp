// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/increment_columns.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "acquisition/record/row.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr double kLongestCountingTime_s = to_seconds(std::chrono::years(10));

}  // namespace

IncrementColumns::IncrementColumns(const ImportMap& map)
    : unit_intervals_(map.units.size()), names_(map.columns()), has_any_(map.counts_increments()) {
  columns_.resize(names_.size());
  if (!has_any_) return;
  std::size_t axis = map.thermometer_columns.size();
  std::size_t interval = axis + map.axis_columns.size() + map.value_columns.size();
  for (std::size_t unit = 0; unit < map.units.size(); ++unit) {
    const auto axes = map.units[unit].axes.size();
    if (!map.counts_increments(unit)) {
      axis += axes;
      continue;
    }
    if (unit < map.interval_columns.size() && map.interval_columns[unit]) {
      columns_[interval] = {.is_summed = true, .interval = interval};
      unit_intervals_[unit] = interval++;
    }
    for (std::size_t i = 0; i < axes; ++i) columns_[axis++] = {.is_summed = true, .interval = unit_intervals_[unit]};
  }
}

bool IncrementColumns::is_counted(std::size_t column, std::span<const double> numbers) const {
  const auto interval = columns_[column].interval;
  return !interval || !std::isnan(numbers[*interval]);
}

Result<void> IncrementColumns::check(std::span<double> numbers) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto interval = columns_[i].interval;
    if (!interval) continue;
    const double seconds = numbers[*interval];
    if (std::isnan(seconds)) {
      numbers[i] = record::kMissing;
    } else if (!(seconds > 0 && seconds <= kLongestCountingTime_s) || from_seconds(seconds) == Duration{}) {
      return failure(FaultKind::bad_file, "",
                     fmt::format("the counting time in column {} is {:g} s, expected a time longer than zero and at "
                                 "most ten years",
                                 describe(names_[*interval]), seconds));
    }
  }
  return {};
}

std::optional<Duration> IncrementColumns::counting_time(std::size_t unit, std::span<const double> numbers,
                                                        Duration fallback) const {
  const auto interval = unit_intervals_[unit];
  if (!interval) return fallback;
  const double seconds = numbers[*interval];
  // A sum may exceed the limit of each row, and the range of a Duration.
  return seconds <= kLongestCountingTime_s ? std::optional(from_seconds(seconds)) : std::nullopt;
}

}  // namespace gyrotherm::exchange
