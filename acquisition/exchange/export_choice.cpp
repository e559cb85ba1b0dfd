// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/export_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "acquisition/exchange/foreign_time.hpp"

namespace gyrotherm::exchange {

namespace {

using record::GyroKind, record::kMissing, record::Record, record::RunInfo;

/// The rows [first, end) of a record that are combined into one.
struct Stretch {
  std::size_t first{}, end{};
  std::int64_t number{};  ///< counted from the run's start
};

/// Returns the number of the stretch of a row. In a record of gyrotherm the slots are seconds; an imported record has
/// its own times. Divides integer nanoseconds, because a quotient of times in seconds may be slightly less than a whole
/// number (0.29 s / 0.01 s).
std::int64_t number_of_stretch(const Record& record, std::size_t row, Duration every) {
  const auto time = record.info.imported ? from_seconds(record.time_s[row]) : kSecond * record.slot[row];
  return time / every - (time % every < Duration{} ? 1 : 0);
}

std::vector<Stretch> make_stretches(const Record& record, const ExportChoice& choice) {
  std::vector<Stretch> stretches;
  const bool together = choice.every > Duration{};
  for (std::size_t row = 0; row < record.slot.size(); ++row) {
    if (choice.from && record.time_s[row] < to_seconds(*choice.from)) continue;
    if (choice.to && record.time_s[row] > to_seconds(*choice.to)) break;
    const auto number = together ? number_of_stretch(record, row, choice.every) : record.slot[row];
    if (!stretches.empty() && stretches.back().number == number)
      ++stretches.back().end;
    else
      stretches.push_back({row, row + 1, number});
  }
  return stretches;
}

/// Returns the part of a column in a stretch; empty if the record does not have the column.
std::span<const double> stretch_values(const std::vector<double>& column, const Stretch& stretch) {
  if (column.size() < stretch.end) return {};
  return std::span(column).subspan(stretch.first, stretch.end - stretch.first);
}

struct Total {
  double sum = 0;
  int count = 0;
};

/// Returns the sum and the count of the numbers that are not NaN.
Total sum_known(std::span<const double> numbers) {
  Total found;
  for (const double number : numbers) {
    if (std::isnan(number)) continue;
    found.sum += number;
    ++found.count;
  }
  return found;
}

double mean(std::span<const double> numbers) {
  const auto [sum, count] = sum_known(numbers);
  return count > 0 ? sum / count : kMissing;
}

double sum_or_missing(std::span<const double> numbers) {
  const auto [sum, count] = sum_known(numbers);
  return count > 0 ? sum : kMissing;
}

/// Returns the sum of the pulses of a stretch. Returns NaN if a second has an interval but no pulses, because the sum
/// of intervals includes that second.
double sum_of_pulses(std::span<const double> pulses, std::span<const double> intervals) {
  for (std::size_t i = 0; i < std::min(pulses.size(), intervals.size()); ++i)
    if (std::isnan(pulses[i]) && !std::isnan(intervals[i])) return kMissing;
  return sum_or_missing(pulses);
}

class RowSelection {
 public:
  RowSelection(const Record& record, const ExportChoice& choice)
      : record_(record), stretches_(make_stretches(record, choice)) {}

  Record selected_record() const {
    Record chosen;
    chosen.info = record_.info;
    chosen.finished = record_.finished;
    for (const Stretch& stretch : stretches_) {
      chosen.slot.push_back(record_.slot[stretch.first]);
      chosen.time_s.push_back(record_.time_s[stretch.first]);
    }
    chosen.set_point_c = means(record_.set_point_c);
    chosen.chamber_air_c = means(record_.chamber_air_c);
    chosen.chamber_set_point_c = means(record_.chamber_set_point_c);
    if (record_.info.has_humidity) chosen.chamber_humidity_percent = means(record_.chamber_humidity_percent);
    if (record_.info.has_dew_point) chosen.chamber_dew_point_c = means(record_.chamber_dew_point_c);
    for (const auto& column : record_.thermometers_c) chosen.thermometers_c.push_back(means(column));
    for (std::size_t unit = 0; unit < record_.units.size(); ++unit) chosen.units.push_back(combine_unit(unit));
    chosen.progress = first_values(record_.progress);
    chosen.state = first_values(record_.state);
    chosen.last_utc = record_.last_utc;
    chosen.gaps = record_.gaps;
    chosen.events = record_.events;
    return chosen;
  }

 private:
  std::vector<double> collect_column(const auto& value_in) const {
    std::vector<double> column;
    column.reserve(stretches_.size());
    for (const Stretch& stretch : stretches_) column.push_back(value_in(stretch));
    return column;
  }

  /// Returns whether the mounting of the unit is constant in a stretch. A mean over both mountings, or over seconds of
  /// handling, is meaningless.
  bool is_in_one_position(const Stretch& stretch) const {
    const double first = record::turned_at(record_, stretch.first);
    for (std::size_t row = stretch.first; row < stretch.end; ++row)
      if (record::turned_at(record_, row) != first) return stretch.end == stretch.first + 1;
    return true;
  }

  std::vector<double> means(const std::vector<double>& column) const {
    if (column.empty()) return {};
    return collect_column([&](const Stretch& stretch) { return mean(stretch_values(column, stretch)); });
  }

  template <class T>
  std::vector<T> first_values(const std::vector<T>& column) const {
    std::vector<T> first;
    if (column.empty()) return first;
    for (const Stretch& stretch : stretches_) first.push_back(column[stretch.first]);
    return first;
  }

  record::UnitColumns combine_unit(std::size_t index) const {
    const auto& columns = record_.units[index];
    const auto& axes = record_.info.units[index].axes;
    record::UnitColumns unit;
    for (std::size_t axis = 0; axis < columns.rotation.size(); ++axis) {
      const auto& rotation = columns.rotation[axis];
      const bool counts = axes[axis].kind == GyroKind::pulse_count;
      unit.rotation.push_back(collect_column([&](const Stretch& stretch) {
        if (!is_in_one_position(stretch)) return kMissing;
        const auto part = stretch_values(rotation, stretch);
        return counts ? sum_of_pulses(part, stretch_values(columns.interval_s, stretch)) : mean(part);
      }));
    }
    unit.interval_s = collect_column(
        [&](const Stretch& stretch) { return sum_or_missing(stretch_values(columns.interval_s, stretch)); });
    for (const auto& column : columns.values) unit.values.push_back(means(column));
    for (const auto& column : columns.true_bias_deg_per_h) unit.true_bias_deg_per_h.push_back(means(column));
    return unit;
  }

  const Record& record_;
  std::vector<Stretch> stretches_;
};

}  // namespace

Result<Duration> parse_moment(const std::string& text, const RunInfo& info, const std::string& option) {
  if (const auto since_start = parse_duration(text)) return *since_start;
  const auto civil = parse_civil_time(text);
  if (!civil || !civil->zone)
    return failure(
        FaultKind::usage, option,
        fmt::format(
            "\"{}\", expected a time since the start such as \"2 h\", or a UTC time such as \"2026-03-01T12:00:00Z\"",
            text));
  if (info.started_utc == Duration{})
    return failure(FaultKind::usage, option, "the record has no start time, expected a time such as \"2 h\"");
  return civil->reading - *civil->zone - info.started_utc;
}

Result<void> check_choice(const ExportChoice& choice, const RunInfo& info) {
  if (choice.every < Duration{} || (!info.imported && choice.every % kSecond != Duration{}))
    return failure(FaultKind::usage, "--every", "expected a whole number of seconds, as the record's rows are");
  if (choice.from && choice.to && *choice.from > *choice.to)
    return failure(FaultKind::usage, "--from", "is after --to");
  return {};
}

Record chosen_rows(Record record, const ExportChoice& choice) {
  const bool is_all = !choice.from && !choice.to && choice.every == Duration{};
  if (is_all) return record;
  return RowSelection(record, choice).selected_record();
}

std::vector<double> calibrated_temperatures(const record::Record& record, std::size_t thermometer) {
  std::vector<double> temperatures = record.thermometers_c[thermometer];
  for (double& temperature : temperatures)
    temperature = record::calibrated(record.info.thermometers[thermometer], {temperature}).value;
  return temperatures;
}

std::vector<double> axis_rates(const record::Record& record, std::size_t unit, std::size_t axis) {
  const record::AxisInfo& info = record.info.units[unit].axes[axis];
  const record::UnitColumns& columns = record.units[unit];
  std::vector<double> rates = columns.rotation[axis];
  for (std::size_t row = 0; row < rates.size(); ++row)
    rates[row] *= info.kind == record::GyroKind::rate ? info.scale : info.scale / columns.interval_s[row];
  return rates;
}

}  // namespace gyrotherm::exchange
