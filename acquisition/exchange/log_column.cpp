// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/log_column.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <cmath>

#include "acquisition/exchange/import_map.hpp"
#include "acquisition/record/row.hpp"

namespace gyrotherm::exchange {

std::optional<LogColumn> parse_log_column(std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == 0 || dot == std::string_view::npos || dot + 1 == name.size()) return std::nullopt;
  std::string_view message = name.substr(0, dot);
  unsigned instance = 0;
  if (const std::size_t bracket = message.find('['); bracket != std::string_view::npos && message.ends_with(']')) {
    const char* end = message.data() + message.size() - 1;
    if (const auto read = std::from_chars(message.data() + bracket + 1, end, instance); read.ptr != end)
      return std::nullopt;
    message = message.substr(0, bracket);
  }
  return LogColumn{std::string(message), instance, std::string(name.substr(dot + 1))};
}

std::string name_of_series(std::string_view message, unsigned instance) {
  return instance == 0 ? std::string(message) : fmt::format("{}[{}]", message, instance);
}

std::size_t size_of(NumberType type) {
  constexpr std::array<std::size_t, 11> kSizes{1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::uint64_t whole_number_at(std::string_view message, std::size_t place, std::size_t bytes) {
  assert(place + bytes <= message.size());
  std::uint64_t number = 0;
  for (std::size_t i = bytes; i-- > 0;) number = number << 8 | static_cast<unsigned char>(message[place + i]);
  return number;
}

namespace {

/// IEEE 754, binary16.
double half(std::uint16_t bits) {
  const int exponent = bits >> 10 & 0x1F, fraction = bits & 0x3FF;
  const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(fraction + 1024, exponent - 25);
  if (exponent == 0x1F) return record::kMissing;
  return (bits & 0x8000) != 0 ? -size : size;
}

double or_missing(double number) { return std::isfinite(number) ? number : record::kMissing; }

}  // namespace

double number_at(std::string_view message, std::size_t place, NumberType type) {
  const std::uint64_t bits = whole_number_at(message, place, size_of(type));
  switch (type) {
    case NumberType::int8: return static_cast<std::int8_t>(bits);
    case NumberType::int16: return static_cast<std::int16_t>(bits);
    case NumberType::int32: return static_cast<std::int32_t>(bits);
    case NumberType::int64: return static_cast<double>(static_cast<std::int64_t>(bits));
    case NumberType::float16: return half(static_cast<std::uint16_t>(bits));
    case NumberType::float32: return or_missing(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case NumberType::float64: return or_missing(std::bit_cast<double>(bits));
    case NumberType::uint8:
    case NumberType::uint16:
    case NumberType::uint32:
    case NumberType::uint64: break;
  }
  return static_cast<double>(bits);
}

std::string describe_missing_log_columns(const std::vector<LogColumn>& missing, const std::vector<LogColumn>& there) {
  std::vector<std::string> names, instead;
  const auto add = [&](std::string name) {
    if (std::ranges::find(instead, name) == instead.end()) instead.push_back(std::move(name));
  };
  for (const LogColumn& column : missing) {
    const auto series = name_of_series(column.message, column.instance);
    names.push_back(series + "." + column.field);
    for (const LogColumn& other : there)
      if (name_of_series(other.message, other.instance) == series) add(series + "." + other.field);
  }
  if (instead.empty())
    for (const LogColumn& other : there) add(name_of_series(other.message, other.instance));
  return describe_missing_columns(names, instead);
}

}  // namespace gyrotherm::exchange
