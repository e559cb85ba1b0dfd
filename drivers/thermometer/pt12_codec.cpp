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

tl::unexpected<Fault> corrupted(std::string_view query, std::string_view line, std::string_view expected) {
  return failure(FaultKind::corrupted, std::string(query), fmt::format("\"{}\" is not {}", line, expected));
}

}  // namespace

Result<std::vector<Result<Celsius>>> decode_pt12_temperatures(std::string_view line) {
  const auto items = split_at_commas(line);
  const auto wrong = [&] { return corrupted("T?", line, fmt::format("{} readings", kPt12Inputs)); };
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

Result<Celsius> decode_pt12_temperature(std::string_view line, std::size_t input) {
  const auto value = parse_number(without_blanks(line));
  if (!value) return corrupted(fmt::format("T{}?", input), line, "a reading");
  return to_celsius(*value, input);
}

Result<std::vector<std::size_t>> decode_pt12_connected(std::string_view line) {
  std::vector<std::size_t> inputs;
  if (without_blanks(line).empty()) return inputs;
  for (const auto item : split_at_commas(line)) {
    std::size_t input{};
    const auto [end, error] = std::from_chars(item.data(), item.data() + item.size(), input);
    const bool ascends = input > (inputs.empty() ? 0 : inputs.back()) && input <= kPt12Inputs;
    if (error != std::errc{} || end != item.data() + item.size() || !ascends)
      return corrupted("CONNECTED?", line, "a list of inputs");
    inputs.push_back(input);
  }
  return inputs;
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
