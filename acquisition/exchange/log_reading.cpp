// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/log_reading.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <chrono>
#include <cmath>
#include <set>

#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kMaxSeries = 4096, kMaxLogFields = 200'000;

/// Converts an IEEE 754 binary16 number. Returns NaN for infinity.
double decode_half(std::uint16_t bits) {
  const int exponent = bits >> 10 & 0x1F, fraction = bits & 0x3FF;
  const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(fraction + 1024, exponent - 25);
  if (exponent == 0x1F) return record::kMissing;
  return (bits & 0x8000) != 0 ? -size : size;
}

double finite_or_missing(double number) { return std::isfinite(number) ? number : record::kMissing; }

/// Returns whether a time is counted since 1970, as in logs of a simulator or ROS, and not since the machine started.
bool is_since_1970(double time_us) {
  constexpr double kFirst_us = 946684800e6, kLast_us = 4102444800e6;  // 2000 to 2100
  return time_us >= kFirst_us && time_us < kLast_us;
}

}  // namespace

std::optional<LogColumn> parse_log_column(std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == 0 || dot == std::string_view::npos || dot + 1 == name.size()) return std::nullopt;
  std::string_view message = name.substr(0, dot);
  unsigned instance = 0;
  if (const std::size_t bracket = message.find('['); bracket != std::string_view::npos && message.ends_with(']')) {
    const char* end = message.data() + message.size() - 1;
    if (const auto read = std::from_chars(message.data() + bracket + 1, end, instance);
        read.ptr != end || read.ec != std::errc())
      return std::nullopt;
    message = message.substr(0, bracket);
  }
  return LogColumn{std::string(message), instance, std::string(name.substr(dot + 1))};
}

std::string series_name(std::string_view message, unsigned instance) {
  return instance == 0 ? std::string(message) : fmt::format("{}[{}]", message, instance);
}

std::size_t number_size(NumberType type) {
  constexpr std::array<std::size_t, 11> kSizes{1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::uint64_t whole_number_at(std::string_view message, std::size_t offset, std::size_t bytes) {
  assert(offset + bytes <= message.size());
  std::uint64_t number = 0;
  for (std::size_t i = bytes; i-- > 0;) number = number << 8 | static_cast<unsigned char>(message[offset + i]);
  return number;
}

double number_at(std::string_view message, std::size_t offset, NumberType type) {
  const std::uint64_t bits = whole_number_at(message, offset, number_size(type));
  switch (type) {
    case NumberType::int8: return static_cast<std::int8_t>(bits);
    case NumberType::int16: return static_cast<std::int16_t>(bits);
    case NumberType::int32: return static_cast<std::int32_t>(bits);
    case NumberType::int64: return static_cast<double>(static_cast<std::int64_t>(bits));
    case NumberType::float16: return decode_half(static_cast<std::uint16_t>(bits));
    case NumberType::float32: return finite_or_missing(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case NumberType::float64: return finite_or_missing(std::bit_cast<double>(bits));
    case NumberType::uint8:
    case NumberType::uint16:
    case NumberType::uint32:
    case NumberType::uint64: break;
  }
  return static_cast<double>(bits);
}

std::string describe_missing_log_columns(const std::vector<LogColumn>& missing,
                                         const std::vector<LogColumn>& available) {
  std::vector<std::string> names, instead;
  const auto add = [&](std::string name) {
    if (std::ranges::find(instead, name) == instead.end()) instead.push_back(std::move(name));
  };
  for (const LogColumn& column : missing) {
    const auto series = series_name(column.message, column.instance);
    names.push_back(series + "." + column.field);
    for (const LogColumn& other : available)
      if (series_name(other.message, other.instance) == series) add(series + "." + other.field);
  }
  if (instead.empty())
    for (const LogColumn& other : available) add(series_name(other.message, other.instance));
  return describe_missing_columns(names, instead);
}

LogReading::LogReading(const ImportMap* map, const TakeRow* take) : map_(map), take_(take) {
  if (map == nullptr) return;
  for (const ColumnName& column : map->columns())
    columns_.push_back(parse_log_column(column.name).value_or(LogColumn{column.name, 0, ""}));
  found_.resize(columns_.size());
  numbers_.resize(columns_.size(), record::kMissing);
}

Result<std::size_t> LogReading::add(const LogSeries& series, const std::string& file) {
  if (series_.size() == kMaxSeries || there_.size() + series.fields.size() > kMaxLogFields)
    return failure(FaultKind::bad_file, file,
                   fmt::format("more than {} series or {} fields, expected fewer", kMaxSeries, kMaxLogFields));
  KnownSeries known{
      .time = series.time, .size = series.size, .first_column = there_.size(), .columns = series.fields.size()};
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

std::vector<LogColumn> LogReading::published_columns() const {
  std::vector<LogColumn> columns;
  std::set<std::string> known_names;
  for (const KnownSeries& known : series_) {
    if (known.messages == 0) continue;
    const auto first = there_.begin() + static_cast<std::ptrdiff_t>(known.first_column);
    for (auto column = first; column != first + static_cast<std::ptrdiff_t>(known.columns); ++column) {
      if (known_names.insert(series_name(column->message, column->instance) + "." + column->field).second)
        columns.push_back(*column);
    }
  }
  return columns;
}

bool LogReading::selects_message(std::string_view message) const {
  return std::ranges::find(columns_, message, &LogColumn::message) != columns_.end();
}

Result<void> LogReading::check_single_series(std::size_t series, const std::string& file) const {
  if (map_->every > Duration{} || rows_ == 0 || series == only_) return {};
  return failure(
      FaultKind::bad_file, file,
      "the map's columns come from several messages, expected every = \"1 s\" (or another interval) in [time], "
      "which combines them");
}

Result<void> LogReading::take(std::size_t series, std::string_view message, const std::string& file, std::uint64_t at) {
  KnownSeries& known = series_[series];
  ++known.messages;
  if (known.wanted.empty()) return {};
  if (message.size() < known.size) {
    ++damaged_;
    return {};
  }
  if (auto alone = check_single_series(series, file); !alone) return alone;
  double time_us = number_at(message, known.time.offset, known.time.type) * known.time.scale;
  constexpr double kMaxEarlierStart_s = 60;  // another topic may begin earlier
  if (rows_ == 0 && is_since_1970(time_us)) {
    counts_since_1970_ = true;
    origin_us_ = std::floor(time_us / 1e6 - kMaxEarlierStart_s) * 1e6;
  }
  const double utc_us = time_us;
  time_us -= origin_us_;
  const bool is_possible = std::abs(time_us) * 1e-6 <= to_seconds(kLongestForeignTime);
  if (!is_possible || time_us < 0) {
    ++damaged_;
    return {};
  }
  if (rows_++ == 0) only_ = series;
  for (const SelectedField& wanted : known.wanted)
    numbers_[wanted.column] = number_at(message, wanted.field.offset, wanted.field.type) * wanted.field.scale;
  ForeignRow row{.time = from_seconds(time_us * 1e-6), .numbers = numbers_};
  if (counts_since_1970_) row.utc = std::chrono::microseconds(static_cast<std::int64_t>(utc_us));
  auto taken = (*take_)(row);
  for (const SelectedField& wanted : known.wanted) numbers_[wanted.column] = record::kMissing;
  if (!taken && taken.error().where.empty()) taken.error().where = fmt::format("{}: message at byte {}", file, at);
  return taken;
}

Result<void> LogReading::finish(const std::string& file) const {
  std::vector<LogColumn> missing;
  for (std::size_t i = 0; i < columns_.size(); ++i)
    if (!found_[i]) missing.push_back(columns_[i]);
  if (!missing.empty()) return failure(FaultKind::bad_file, file, describe_missing_log_columns(missing, there_));
  if (map_ != nullptr && rows_ == 0)
    return failure(
        FaultKind::bad_file, file,
        "the log ends, expected at least one message with the map's columns" +
            (damaged_ > 0 ? fmt::format("; {} have an impossible time or are cut short", damaged_) : std::string()));
  if (map_ != nullptr && damaged_ > rows_)
    return failure(FaultKind::bad_file, file,
                   fmt::format("{} messages have an impossible time or are cut short, more than the {} that do not",
                               damaged_, rows_));
  return {};
}

}  // namespace gyrotherm::exchange
