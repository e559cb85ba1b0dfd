// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/channel_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/exchange/increment_columns.hpp"
#include "acquisition/record/row.hpp"
#include "core/count_text.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr double kOverload = 1e30;

/// Returns whether sensors or loggers send this number if they have no value: a DS18B20 that does not answer, an open
/// thermocouple, various loggers.
bool is_known_sentinel(double number) {
  static constexpr std::array kSentinels{-127.0,   -999.0,  -999.9,  -99.9,  -99.99, -9999.0, 999.0,
                                         999.9,    9999.0,  8888.0,  850.0,  1370.0, 3276.7,  327.67,
                                         -32768.0, 32767.0, 65535.0, -200.0, -273.0};
  return std::ranges::find(kSentinels, number) != kSentinels.end();
}

/// The remedy if a column has many impossible values.
constexpr std::string_view kRawCounts =
    "if the column has raw counts or another unit, set its scale and offset (°C = number × scale + offset); otherwise ";

std::string quoted_texts(const MissingTexts& texts) {
  std::string list;
  for (const auto& [text, count] : texts)
    list += fmt::format("{}\"{}\" {}", list.empty() ? "" : ", ", plain(text), count);
  return list;
}

}  // namespace

std::string describe(const ChannelSummary& channel) {
  std::string text = fmt::format("{}: {}", channel.name, format_count(channel.values, "value"));
  if (channel.values > 0) text += fmt::format(", {:.6g} to {:.6g} {}", channel.least, channel.greatest, channel.unit);
  if (channel.missing > 0) text += fmt::format(", {} missing", channel.missing);
  if (!channel.missing_texts.empty()) text += fmt::format(" ({})", quoted_texts(channel.missing_texts));
  if (channel.outside > 0) text += fmt::format(", {} of them outside the valid range", channel.outside);
  return text;
}

void ChannelTally::Extremes::push(double number, double sign) {
  const auto end = numbers.begin() + static_cast<std::ptrdiff_t>(size);
  const auto position = std::find_if(numbers.begin(), end, [&](double other) { return sign * number <= sign * other; });
  const auto at = static_cast<std::size_t>(position - numbers.begin());
  if (position != end && *position == number) {
    ++counts[at];
    return;
  }
  if (at == kExtremes) return;
  size = std::min(size + 1, kExtremes);
  for (std::size_t i = size - 1; i > at; --i) {
    numbers[i] = numbers[i - 1];
    counts[i] = counts[i - 1];
  }
  numbers[at] = number;
  counts[at] = 1;
}

void ChannelTally::push_extremes(double value, Extremes& least, Extremes& greatest) {
  if (least.size < kExtremes || value <= least.numbers.back()) least.push(value, 1);
  if (greatest.size < kExtremes || value >= greatest.numbers.back()) greatest.push(value, -1);
}

ChannelTally::ChannelTally(const ImportMap& map)
    : is_text_(map.format == FileFormat::text),
      is_log_(map.format == FileFormat::ulog || map.format == FileFormat::dataflash),
      is_combined_(map.every > Duration{}) {
  for (std::size_t i = 0; i < map.thermometer_columns.size(); ++i) {
    const auto& column = map.thermometer_columns[i];
    add(Kind::temperature, map.thermometers[i], column.column, "°C", column.scale, column.offset);
  }
  auto axis_column = map.axis_columns.begin();
  for (const auto& unit : map.units)
    for (std::size_t i = 0; i < unit.axes.size(); ++i) {
      const bool is_rate = unit.axes[i].kind == record::GyroKind::rate;
      add(is_rate ? Kind::rate : Kind::increment, record::axis_label(unit, i), *axis_column++,
          is_rate ? "°/h" : "arcsec", unit.axes[i].scale, 0);
    }
  auto value_column = map.value_columns.begin();
  for (const auto& unit : map.units)
    for (const auto& value : unit.values) {
      const auto& [column, scale, offset, valid] = *value_column++;
      add(value.is_temperature ? Kind::temperature : Kind::value, unit.name + "." + value.name, column, value.unit,
          scale, offset);
    }
  const auto valid = map.valid_ranges();
  const IncrementColumns increments(map);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    columns_[i].valid = valid[i];
    columns_[i].interval = increments.find_counting_times(i);
  }
  values_.resize(columns_.size());
}

void ChannelTally::add(Kind kind, std::string name, const ColumnName& column, std::string unit, double scale,
                       double offset) {
  watch_.add({.name = name,
              .unit = unit,
              .is_temperature = kind == Kind::temperature,
              .is_axis = kind == Kind::rate || kind == Kind::increment,
              .scale = scale,
              .offset = offset,
              .has_missing_texts = is_text_});
  columns_.push_back({.kind = kind,
                      .summary = {.name = std::move(name), .column = describe(column), .unit = std::move(unit)},
                      .scale = scale,
                      .offset = offset});
}

std::string ChannelTally::remedy(const Column& column, double number) const {
  if (!is_text_) return "expected valid = [LOW, HIGH] for this column in the map, in the file's numbers";
  return fmt::format(
      "expected missing = [\"{}\"] in [file] if it marks a missing value, or valid = [LOW, HIGH] for this "
      "column in the map",
      (number - column.offset) / column.scale);
}

bool ChannelTally::is_like_others(const Column& column, double value) {
  constexpr std::size_t kFew = 20;
  constexpr double kNear = 0.2;
  return column.summary.values < kFew || std::abs(value - column.last) < kNear * std::abs(value);
}

Fault ChannelTally::impossible_value_fault(const Column& column, double number) const {
  const double value = number * column.scale + column.offset;
  std::string what;
  if (std::isinf(value))
    what = fmt::format("{:g} of column {} is too large with the map's scale {:g}, expected a smaller one", number,
                       column.summary.column, column.scale);
  else if (std::abs(number) >= kOverload)
    what = fmt::format("{:g} of column {} is a value that instruments send for an overload; {}", number,
                       column.summary.column, remedy(column, value));
  else if (column.kind == Kind::temperature)
    what = fmt::format("{:g} of column {} is {:g} °C, {}; {}{}", number, column.summary.column, value,
                       value < 0 ? "below absolute zero" : "hotter than any thermometer",
                       is_like_others(column, value) ? kRawCounts : "", remedy(column, value));
  else
    what = fmt::format("{:g} of column {} is {:g} °/h, faster than any gyro: is its scale {:g} right? Otherwise {}",
                       number, column.summary.column, value, column.scale, remedy(column, value));
  return {FaultKind::bad_file, "", std::move(what)};
}

Result<void> ChannelTally::push(Duration time, std::span<double> numbers) {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    Column& column = columns_[i];
    double& number = numbers[i];
    values_[i] = record::kMissing;
    if (std::isnan(number)) {
      ++column.summary.missing;
      continue;
    }
    if (column.valid && (number < column.valid->low || number > column.valid->high)) {
      number = record::kMissing;
      ++column.summary.missing;
      ++column.summary.outside;
      continue;
    }
    const double value = number * column.scale + column.offset;
    const bool is_possible = column.kind == Kind::temperature ? value >= kAbsoluteZero_c && value <= kHottest_c
                             : column.kind == Kind::rate      ? std::abs(value) <= kFastest_deg_per_h
                                                              : !std::isinf(value);
    const bool is_wild = refuses_impossible_ && (!is_possible || std::abs(number) >= kOverload);
    if (is_wild || std::isinf(value)) return failure(impossible_value_fault(column, number));
    ++column.summary.values;
    values_[i] = column.last = value;
    push_extremes(value, column.least, column.greatest);
    // 1 arcsec/s is 1 °/h.
    if (column.interval) push_extremes(value / numbers[*column.interval], column.least_rate, column.greatest_rate);
  }
  watch_.push(time, values_);
  return {};
}

std::vector<ChannelSummary> ChannelTally::channels(const std::vector<MissingTexts>& missing) const {
  std::vector<ChannelSummary> channels;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    ChannelSummary& channel = channels.emplace_back(columns_[i].summary);
    if (is_log_) channel.missing = channel.outside;  // a message has only some columns
    if (i < missing.size()) channel.missing_texts = missing[i];
    if (channel.values == 0) continue;
    channel.least = columns_[i].least.numbers.front();
    channel.greatest = columns_[i].greatest.numbers.front();
  }
  return channels;
}

bool ChannelTally::is_error_value(const Column& column, double value) {
  return is_known_sentinel(value) || is_known_sentinel((value - column.offset) / column.scale);
}

/// Examines both ends of the values for a few numbers that are far from all others. Fails with bad_file if they are
/// temperatures and either a known error value or at least 40 K away; otherwise adds a note.
Result<void> ChannelTally::check_isolated(const Column& column, const std::string& file, Notes& notes) const {
  constexpr double kMinGap_k = 20, kErrorGap_k = 40, kMinSentinelGap_k = 10, kMaxShare = 0.2, kRangeMultiple = 50;
  constexpr std::size_t kMinValues = 20;
  if (column.summary.values < kMinValues || column.kind == Kind::value || column.valid) return {};
  const bool is_temperature = column.kind == Kind::temperature;
  // An increment may be small only because its counting time is short.
  const auto& least = column.interval ? column.least_rate : column.least;
  const auto& greatest = column.interval ? column.greatest_rate : column.greatest;
  for (const auto* extremes : {&least, &greatest}) {
    const auto& inner = extremes == &least ? greatest : least;
    std::size_t count = 0;
    const bool is_one_error = is_temperature && is_error_value(column, extremes->numbers.front());
    for (std::size_t i = 0; i + 1 < extremes->size; ++i) {
      count += extremes->counts[i];
      const double at = extremes->numbers[i], next = extremes->numbers[i + 1];
      const double apart = std::abs(at - next), rest = std::abs(next - inner.numbers.front());
      const bool is_few = static_cast<double>(count) <= kMaxShare * static_cast<double>(column.summary.values);
      if (!is_few && !(is_one_error && i == 0)) break;
      const bool is_sentinel = is_error_value(column, at);
      const double limit = is_temperature ? (is_sentinel ? kMinSentinelGap_k : kMinGap_k) : kRangeMultiple * rest;
      if (apart < (is_few ? limit : kErrorGap_k) || (is_temperature && !is_sentinel && apart < rest / 4) || limit == 0)
        continue;
      const auto what = fmt::format(
          "{} of the {} values of column {} differ by {:.4g} {} or more from all others, the "
          "furthest at {:g}",
          count, column.summary.values, column.summary.column, apart, column.interval ? "°/h" : column.summary.unit,
          extremes->numbers.front());
      if (is_temperature && (is_sentinel || apart >= kErrorGap_k))
        return failure(FaultKind::bad_file, file, what + "; " + remedy(column, at));
      notes.push_back(what);
      break;
    }
  }
  return {};
}

Result<void> ChannelTally::judge(const std::string& file, const std::vector<MissingTexts>& missing,
                                 Notes& notes) const {
  constexpr std::size_t kMinValuesToJudge = 10, kMissingToWarn = 20;
  const auto channels = this->channels(missing);
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const ChannelSummary& channel = channels[i];
    const bool is_axis = columns_[i].kind == Kind::rate || columns_[i].kind == Kind::increment;
    if (channel.values == 0) {
      const auto what = fmt::format("column {} has no value for {}{}", channel.column, channel.name,
                                    channel.missing_texts.empty() ? "" : ": " + quoted_texts(channel.missing_texts));
      if (is_axis) return failure(FaultKind::bad_file, file, what + ", expected some, or another column in the map");
      notes.push_back(what);
      continue;
    }
    if (channel.values >= kMinValuesToJudge && channel.least == channel.greatest)
      notes.push_back(
          fmt::format("all {} values of {} are {:g} {}", channel.values, channel.name, channel.least, channel.unit));
    const auto all = channel.missing + channel.values;
    const bool is_much = is_combined_ ? 2 * channel.missing > all : kMissingToWarn * channel.missing > all;
    // A combined row needs only one value of a slower column.
    const auto* effect = is_axis ? "rows without a rate are not used"
                         : is_combined_
                             ? "a combined row uses the values that it has"
                             : "clusters with a missing temperature are left out, unless the map does not "
                               "name the channel; if a slower instrument wrote it, combine rows by \"every\"";
    if (is_much && all >= kMinValuesToJudge)
      notes.push_back(fmt::format("{}{} of {} values of {} are missing ({:.0f} %); {}",
                                  is_combined_ && !is_axis ? "" : "warning: ", channel.missing, all, channel.name,
                                  100.0 * static_cast<double>(channel.missing) / static_cast<double>(all), effect));
    if (auto isolated = check_isolated(columns_[i], file, notes); !isolated) return isolated;
  }
  auto failed = watch_.warnings();
  notes.insert(notes.end(), std::make_move_iterator(failed.begin()), std::make_move_iterator(failed.end()));
  return {};
}

}  // namespace gyrotherm::exchange
