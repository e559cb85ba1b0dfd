// SPDX-License-Identifier: Apache-2.0
#include "drivers/thermometer/pt12_codec.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "drivers/thermometer/placed_readings.hpp"

namespace gyrotherm::drivers {

namespace {

constexpr TemperatureRange kPlatinum{{-200}, {850}};

std::string_view without_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

bool is_nan(std::string_view text) {
  const auto same = [](char a, char b) { return (a | 0x20) == b; };
  return std::ranges::equal(text, std::string_view("nan"), same);
}

/// A number in standard or scientific notation, or NaN; nothing that a number is only the beginning of.
std::optional<double> parse_number(std::string_view text) {
  if (is_nan(text)) return std::numeric_limits<double>::quiet_NaN();
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text[0] == '-' || text.find_first_not_of("0123456789.eE+-") != std::string_view::npos)
    return std::nullopt;
  double value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return negative ? -value : value;
}

std::vector<std::string_view> split_at_commas(std::string_view line) {
  std::vector<std::string_view> items;
  for (auto rest = line;;) {
    const auto comma = rest.find(',');
    items.push_back(without_blanks(rest.substr(0, comma)));
    if (comma == std::string_view::npos) return items;
    rest.remove_prefix(comma + 1);
  }
}

Result<Celsius> to_celsius(double value, std::size_t input) {
  const auto place = fmt::format("T{}", input);
  if (std::isnan(value)) return failure(FaultKind::out_of_range, place, "no probe is connected (NaN)");
  return within(kPlatinum, {value}, place);
}

}  // namespace

Result<std::vector<Result<Celsius>>> decode_pt12_temperatures(std::string_view line) {
  const auto items = split_at_commas(line);
  const auto wrong = [&] {
    return failure(FaultKind::corrupted, "T?", fmt::format("\"{}\" is not {} readings", line, kPt12Inputs));
  };
  if (items.size() != kPt12Inputs) return wrong();
  std::vector<Result<Celsius>> readings;
  readings.reserve(kPt12Inputs);
  for (const auto item : items) {
    const auto value = parse_number(item);
    if (!value) return wrong();
    readings.push_back(to_celsius(*value, readings.size() + 1));
  }
  return readings;
}

std::string encode_pt12_temperatures(std::span<const std::optional<double>> celsius) {
  std::string line;
  for (const auto& reading : celsius) {
    if (!line.empty()) line += ", ";
    line += reading ? fmt::format("{:.5f}", *reading) : "NaN";
  }
  return line;
}

}  // namespace gyrotherm::drivers
