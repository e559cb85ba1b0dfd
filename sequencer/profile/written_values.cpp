#include "sequencer/profile/written_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

namespace gyrotherm {
namespace {

constexpr Celsius kColdest{-273.15};
constexpr Celsius kHottest{1000};
constexpr CelsiusPerMinute kFastest{1000};

Duration whole_seconds(Duration d) { return std::chrono::ceil<std::chrono::seconds>(d); }

bool sensible(Celsius t) { return t >= kColdest && t <= kHottest; }
bool sensible(CelsiusPerMinute rate) { return rate > CelsiusPerMinute{0} && rate <= kFastest; }

void check(const TomlTable& table, std::string_view key, Celsius t) {
  if (sensible(t)) return;
  table.mistake(
      key, fmt::format("\"{}\" is {:g} °C, expected {:g} to {:g} °C", key, t.value, kColdest.value, kHottest.value));
}

void check(const TomlTable& table, std::string_view key, CelsiusPerMinute rate) {
  if (sensible(rate)) return;
  table.mistake(key, fmt::format("\"{}\" is {:g} °C/min, expected more than 0, at most {:g} °C/min", key, rate.value,
                                 kFastest.value));
}

void check(const TomlTable& table, std::string_view key, Duration d) {
  if (d <= Duration::zero()) table.mistake(key, fmt::format("\"{}\" is zero, expected a time longer than zero", key));
}

/// The range that two values make; anything else is a mistake, and the neutral range stands in.
template <class T>
WrittenRange<T> range_of(const TomlTable& table, std::string_view key, const std::vector<T>& values,
                         WrittenRange<T> neutral) {
  if (values.size() != 2 || values[0] > values[1]) {
    table.mistake(key, fmt::format("\"{}\" is not a range, expected [low, high]", key));
    return neutral;
  }
  check(table, key, values[0]);
  check(table, key, values[1]);
  return {values[0], values[1]};
}

}  // namespace

Duration read_time(const TomlTable& table, std::string_view key) {
  if (!table.has(key)) return table.duration(key);  // notes that it is missing
  const auto time = table.duration(key, kSecond);
  check(table, key, time);
  return whole_seconds(time);
}

std::optional<Duration> read_time_if_any(const TomlTable& table, std::string_view key) {
  return table.has(key) ? std::optional(read_time(table, key)) : std::nullopt;
}

Celsius read_temperature(const TomlTable& table, std::string_view key) {
  const auto t = table.celsius(key);
  check(table, key, t);
  return t;
}

std::optional<Celsius> read_temperature_if_any(const TomlTable& table, std::string_view key) {
  return table.has(key) ? std::optional(read_temperature(table, key)) : std::nullopt;
}

std::optional<CelsiusPerMinute> read_rate_if_any(const TomlTable& table, std::string_view key) {
  if (!table.has(key)) return std::nullopt;
  const auto rate = table.rate(key, kFastest);
  check(table, key, rate);
  return rate;
}

std::vector<CelsiusPerMinute> read_rates(const TomlTable& table, std::string_view key) {
  auto rates = table.rates(key);
  for (const auto rate : rates) check(table, key, rate);
  return rates;
}

Kelvins read_band(const TomlTable& table, std::string_view key, Kelvins fallback) {
  const auto band = table.kelvins(key, fallback);
  if (band <= Kelvins{0}) table.mistake(key, fmt::format("\"{}\" is {:g} K, expected more than 0 K", key, band.value));
  return band;
}

WrittenRange<CelsiusPerMinute> read_rate_range(const TomlTable& table, std::string_view key) {
  return range_of(table, key, table.rates(key), {kFastest, kFastest});
}

WrittenRange<Duration> read_time_range(const TomlTable& table, std::string_view key) {
  const auto range = range_of(table, key, table.durations(key), {kSecond, kSecond});
  return {whole_seconds(range.low), whole_seconds(range.high)};
}

std::vector<WrittenRange<Celsius>> read_temperature_ranges(const TomlTable& table, std::string_view key) {
  std::vector<WrittenRange<Celsius>> ranges;
  for (const auto& row : table.number_rows(key)) {
    std::vector<Celsius> ends;
    std::transform(row.begin(), row.end(), std::back_inserter(ends), [](double celsius) { return Celsius{celsius}; });
    ranges.push_back(range_of(table, key, ends, {}));
  }
  if (ranges.empty()) table.mistake(key, fmt::format("\"{}\" is empty, expected rows of [low, high]", key));
  return ranges;
}

}  // namespace gyrotherm
