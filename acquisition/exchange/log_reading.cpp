// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/log_reading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

LogReading::LogReading(const ImportMap* map, const TakeRow* take) : map_(map), take_(take) {
  if (map == nullptr) return;
  for (const ColumnName& column : map->columns())
    columns_.push_back(parse_log_column(column.name).value_or(LogColumn{column.name, 0, ""}));
  found_.resize(columns_.size());
  numbers_.resize(columns_.size(), record::kMissing);
}

namespace {

/// Whether microseconds count since 1970, as those of a simulator or of ROS do, and not since the machine was started.
bool is_since_1970(double time_us) {
  constexpr double kFirst_us = 946684800e6, kLast_us = 4102444800e6;  // 2000 to 2100
  return time_us >= kFirst_us && time_us < kLast_us;
}

constexpr std::size_t kMostSeries = 4096, kMostLogFields = 200'000;

}  // namespace

Result<std::size_t> LogReading::add(LogSeries series, const std::string& file) {
  if (series_.size() == kMostSeries || there_.size() + series.fields.size() > kMostLogFields)
    return failure(FaultKind::bad_file, file,
                   fmt::format("more than {} series or {} fields, expected fewer", kMostSeries, kMostLogFields));
  Known known{.time = series.time, .size = series.size, .first_column = there_.size(), .columns = series.fields.size()};
  for (const LogField& field : series.fields) {
    there_.push_back({plain(series.message), series.instance, plain(field.name)});
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const LogColumn& column = columns_[i];
      if (column.message != series.message || column.instance != series.instance || column.field != field.name)
        continue;
      known.wanted.push_back({i, field});
      found_[i] = true;
    }
  }
  series_.push_back(std::move(known));
  return series_.size() - 1;
}

std::vector<LogColumn> LogReading::published() const {
  std::vector<LogColumn> columns;
  std::set<std::string> known_names;
  for (const Known& known : series_) {
    if (known.messages == 0) continue;
    const auto first = there_.begin() + static_cast<std::ptrdiff_t>(known.first_column);
    for (auto column = first; column != first + static_cast<std::ptrdiff_t>(known.columns); ++column) {
      if (known_names.insert(name_of_series(column->message, column->instance) + "." + column->field).second)
        columns.push_back(*column);
    }
  }
  return columns;
}

bool LogReading::wants(std::string_view message) const {
  return std::ranges::find(columns_, message, &LogColumn::message) != columns_.end();
}

Result<void> LogReading::check_alone(std::size_t series, const std::string& file) const {
  if (map_->every > Duration{} || rows_ == 0 || series == only_) return {};
  return failure(
      FaultKind::bad_file, file,
      "the map's columns come from several messages, expected every = \"1 s\" (or another stretch) in [time], "
      "which puts them together");
}

Result<void> LogReading::take(std::size_t series, std::string_view message, const std::string& file, std::uint64_t at) {
  Known& known = series_[series];
  ++known.messages;
  if (known.wanted.empty()) return {};
  if (message.size() < known.size) {
    ++damaged_;
    return {};
  }
  if (auto alone = check_alone(series, file); !alone) return alone;
  double time_us = number_at(message, known.time.place, known.time.type) * known.time.scale;
  constexpr double kEarlier_s = 60;  // by which another topic may begin
  if (rows_ == 0 && is_since_1970(time_us)) {
    counts_since_1970_ = true;
    origin_us_ = std::floor(time_us / 1e6 - kEarlier_s) * 1e6;
  }
  const double utc_us = time_us;
  time_us -= origin_us_;
  const bool is_possible = std::abs(time_us) * 1e-6 <= to_seconds(kLongestForeignTime);
  if (!is_possible || time_us < 0) {
    ++damaged_;
    return {};
  }
  if (rows_++ == 0) only_ = series;
  for (const Wanted& wanted : known.wanted)
    numbers_[wanted.column] = number_at(message, wanted.field.place, wanted.field.type) * wanted.field.scale;
  ForeignRow row{.time = from_seconds(time_us * 1e-6), .numbers = numbers_};
  if (counts_since_1970_) row.utc = std::chrono::microseconds(static_cast<std::int64_t>(utc_us));
  auto taken = (*take_)(row);
  for (const Wanted& wanted : known.wanted) numbers_[wanted.column] = record::kMissing;
  if (!taken && taken.error().where.empty()) taken.error().where = fmt::format("{}: message at byte {}", file, at);
  return taken;
}

Result<void> LogReading::finish(const std::string& file) const {
  std::vector<LogColumn> missing;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (!found_[i]) missing.push_back(columns_[i]);
  if (!missing.empty()) return failure(FaultKind::bad_file, file, describe_missing_log_columns(missing, there_));
  if (map_ != nullptr && rows_ == 0)
    return failure(FaultKind::bad_file, file,
                   "the log ends, expected at least one message with the map's columns" +
                       (damaged_ > 0 ? fmt::format("; {} of them have no possible time or are cut short", damaged_)
                                     : std::string()));
  return {};
}

}  // namespace gyrotherm::exchange
