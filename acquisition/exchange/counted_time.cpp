// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/counted_time.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/row.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::int64_t kLongest_s = std::numeric_limits<std::int64_t>::max() / 4;  // so that two can be added

/// The same time, its part between zero and a second.
CountedTime in_order(std::int64_t seconds, Duration part) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(part);
  return {seconds + whole.count(), part - whole};
}

/// So many units and a fraction of the next.
CountedTime counted(std::int64_t whole, double fraction, Duration unit) {
  const Duration part = from_seconds(fraction * to_seconds(unit));
  if (unit < kSecond) {
    const std::int64_t in_a_second = kSecond / unit;
    return in_order(whole / in_a_second, unit * (whole % in_a_second) + part);
  }
  const std::int64_t seconds = unit / kSecond, longest = kLongest_s / seconds;
  return in_order(std::clamp(whole, -longest, longest) * seconds, part);
}

struct Decimal {
  std::int64_t whole{};
  double fraction{};  ///< of the same sign
};

std::optional<std::uint64_t> digits_in(std::string_view text) {
  std::uint64_t number = 0;
  if (text.empty()) return number;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// Nothing of a number with an exponent, or one that 64 bits do not hold.
std::optional<Decimal> decimal_in(std::string_view text) {
  constexpr std::size_t kMostBehindPoint = 18;
  static constexpr std::array<double, kMostBehindPoint + 1> kPowers{
      1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18};
  const bool is_negative = text.starts_with('-');
  if (is_negative || text.starts_with('+')) text.remove_prefix(1);
  const std::size_t point = std::min(text.find('.'), text.size());
  const auto before = text.substr(0, point), behind = text.substr(std::min(point + 1, text.size()));
  const auto counted = behind.substr(0, kMostBehindPoint), rest = behind.substr(counted.size());
  if (before.size() + behind.size() == 0 || rest.find_first_not_of("0123456789") != std::string_view::npos)
    return std::nullopt;
  const auto whole = digits_in(before), part = digits_in(counted);
  if (!whole || !part || *whole > std::numeric_limits<std::int64_t>::max()) return std::nullopt;
  const Decimal number{static_cast<std::int64_t>(*whole), static_cast<double>(*part) / kPowers[counted.size()]};
  return is_negative ? Decimal{-number.whole, -number.fraction} : number;
}

}  // namespace

CountedTime counted_time(std::int64_t number, Duration unit) { return counted(number, 0, unit); }

CountedTime counted_time(double number, Duration unit) {
  constexpr double kBeyond = 0x1p63;
  const double whole = std::floor(number);
  if (!(std::abs(whole) < kBeyond)) return {number < 0 ? -kLongest_s : kLongest_s};
  return counted(static_cast<std::int64_t>(whole), number - whole, unit);
}

std::optional<CountedTime> parse_counted_time(std::string_view text, Duration unit) {
  if (const auto plain = decimal_in(text)) return counted(plain->whole, plain->fraction, unit);
  const auto number = record::number_in(text);
  return number ? std::optional(counted_time(*number, unit)) : std::nullopt;
}

std::optional<Duration> between(const CountedTime& first, const CountedTime& second) {
  const std::int64_t seconds = second.seconds - first.seconds;
  if (std::abs(seconds) > kLongestForeignTime / kSecond) return std::nullopt;
  const Duration time = kSecond * seconds + (second.part - first.part);
  return std::chrono::abs(time) <= kLongestForeignTime ? std::optional(time) : std::nullopt;
}

std::optional<Duration> utc_of(const CountedTime& since_1970) {
  constexpr std::int64_t kBeyond_s = std::int64_t{1} << 33;
  if (since_1970.seconds < 0 || since_1970.seconds >= kBeyond_s) return std::nullopt;
  const Duration utc = kSecond * since_1970.seconds + since_1970.part;
  return record::is_possible_time(utc) ? std::optional(utc) : std::nullopt;
}

CountedTime operator+(const CountedTime& a, const CountedTime& b) {
  return in_order(a.seconds + b.seconds, a.part + b.part);
}

}  // namespace gyrotherm::exchange
