// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/lakeshore_218_codec.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>

namespace gyrotherm::drivers {

namespace {

constexpr Celsius kAbsoluteZero{-273.15};
constexpr Celsius kHottest{1000};  ///< above every sensor that the instrument takes

/// A sign, digits, a point, digits; nothing else.
std::optional<double> parse_crdg_reading(std::string_view text) {
  if (text.size() < 2 || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const auto digits = text.substr(1);
  if (digits.find_first_not_of("0123456789.") != std::string_view::npos) return std::nullopt;
  double value{};
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed);
  if (error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return text[0] == '-' ? -value : value;
}

Result<Celsius> plausible(Celsius reading, std::size_t input) {
  if (reading >= kAbsoluteZero && reading <= kHottest) return reading;
  return failure(FaultKind::out_of_range, fmt::format("input {}", input),
                 fmt::format("{} °C cannot be", reading.value));
}

/// As "{:+08.3f}" does for three decimals; a virtual run prints millions of them, and whole numbers are printed faster.
void append_reading(std::string& line, double reading, int decimals) {
  constexpr double kMost = 999;
  constexpr int kMostDecimals = 6;
  if (!(std::abs(reading) < kMost) || decimals < 1 || decimals > kMostDecimals) {
    line += fmt::format("{:+0{}.{}f}", reading, decimals + 5, decimals);
    return;
  }
  auto rest = static_cast<std::int64_t>(std::nearbyint(std::abs(reading) * std::pow(10, decimals)));
  std::array<char, 12> digits;
  const auto size = static_cast<std::size_t>(decimals) + 5;
  for (std::size_t i = size - 1; i > 0; --i) {
    if (i == 4) {
      digits[i] = '.';
      continue;
    }
    digits[i] = static_cast<char>('0' + rest % 10);
    rest /= 10;
  }
  digits[0] = std::signbit(reading) ? '-' : '+';
  line.append(digits.data(), size);
}

}  // namespace

Result<std::vector<Result<Celsius>>> decode_crdg(std::string_view line) {
  const auto wrong = [&] {
    return failure(FaultKind::corrupted, "CRDG?", fmt::format("\"{}\" is not {} readings", line, kLakeshore218Inputs));
  };
  std::vector<Result<Celsius>> readings;
  readings.reserve(kLakeshore218Inputs);
  for (auto rest = line; readings.size() < kLakeshore218Inputs;) {
    const auto comma = rest.find(',');
    const auto value = parse_crdg_reading(rest.substr(0, comma));
    if (!value) return wrong();
    readings.push_back(plausible({*value}, readings.size() + 1));
    const bool last = readings.size() == kLakeshore218Inputs;
    if (last != (comma == std::string_view::npos)) return wrong();
    if (!last) rest.remove_prefix(comma + 1);
  }
  return readings;
}

std::string encode_crdg(std::span<const double> celsius, int decimals) {
  std::string line;
  for (const double reading : celsius) {
    if (!line.empty()) line += ',';
    append_reading(line, reading, decimals);
  }
  return line;
}

}  // namespace gyrotherm::drivers
