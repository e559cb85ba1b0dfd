// SPDX-License-Identifier: Apache-2.0
#include "core/number_hint.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm {
namespace {

/// En dash, minus sign, and the hyphens and full-width forms that word processors insert.
constexpr std::array<std::string_view, 6> kOtherMinuses{"\u2212", "\u2013", "\u2010", "\u2011", "\u2014", "\uFF0D"};

bool is_decimal_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

bool has_other_minus(std::string_view text) {
  for (const auto minus : kOtherMinuses)
    if (text.find(minus) != std::string_view::npos) return true;
  return false;
}

/// Returns the position of a comma between two digits, or npos.
std::size_t find_decimal_comma(std::string_view text) {
  for (std::size_t i = 1; i + 1 < text.size(); ++i)
    if (text[i] == ',' && is_decimal_digit(text[i - 1]) && is_decimal_digit(text[i + 1])) return i;
  return std::string_view::npos;
}

struct NumberAndUnit {
  double value{};
  std::string_view unit;
};

std::optional<NumberAndUnit> split_number(std::string_view text) {
  text = trimmed(text);
  NumberAndUnit split;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), split.value);
  if (error != std::errc{} || !std::isfinite(split.value)) return std::nullopt;
  split.unit = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
  return split;
}

/// Returns the unit of time that `word` spells out, or an empty text.
std::string_view time_unit(std::string_view word) {
  using Spelling = std::pair<std::string_view, std::string_view>;
  constexpr std::array<Spelling, 15> kWords{{{"sec", "s"},
                                             {"secs", "s"},
                                             {"second", "s"},
                                             {"seconds", "s"},
                                             {"msec", "ms"},
                                             {"m", "min"},
                                             {"mins", "min"},
                                             {"minute", "min"},
                                             {"minutes", "min"},
                                             {"hr", "h"},
                                             {"hrs", "h"},
                                             {"hour", "h"},
                                             {"hours", "h"},
                                             {"day", "d"},
                                             {"days", "d"}}};
  for (const auto& [spelt, unit] : kWords)
    if (spelt == word) return unit;
  return {};
}

}  // namespace

std::string hint_at_number(std::string_view text) {
  if (has_other_minus(text)) return "its minus sign is another character; write \"-\"";
  if (const auto comma = find_decimal_comma(text); comma != std::string_view::npos) {
    std::string corrected(text);
    corrected[comma] = '.';
    return fmt::format("it has a decimal comma; write \"{}\"", corrected);
  }
  const auto split = split_number(text);
  if (!split) return {};
  constexpr double kZeroInFahrenheit = 32, kFahrenheitPerKelvin = 1.8;
  if (split->unit == "°F" || split->unit == "F")
    return fmt::format("{:g} °F is \"{:.4g} °C\"", split->value,
                       (split->value - kZeroInFahrenheit) / kFahrenheitPerKelvin);
  if (const auto unit = time_unit(split->unit); !unit.empty())
    return fmt::format("write \"{:g} {}\"", split->value, unit);
  return split->unit.starts_with(':') ? "write the time with its units, as \"1 h 20 min\"" : "";
}

}  // namespace gyrotherm
