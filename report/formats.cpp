// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>

#include "report/words.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kMinus = "−";
constexpr const char* kNarrowSpace = "\u202f";
constexpr const char* kWordJoiner = "\u2060";
constexpr const char* kPlusMinus = "\u00a0±\u00a0";  // non-breaking spaces
constexpr const char* kTimesTenTo = "\u00a0×\u00a010";
constexpr const char* kDash = "–";
constexpr int kDigitsOfU = 2;
constexpr int kDigitsOfAValue = 4;
/// Most digits of a value, of its U and of a limit in a comparison.
constexpr int kMostDigits = 12;
/// Numbers below 10^kLeastPower, or of at least 10^kGreatestPower, are written with a power of ten.
constexpr int kLeastPower = -4, kGreatestPower = 7;
/// Values with U and more decimals than these are written with a power of ten.
constexpr int kMostDecimals = 8;

std::string superscript(int n) {
  static constexpr std::array<const char*, 10> kDigits = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = n < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(n))) text += kDigits[static_cast<std::size_t>(digit - '0')];
  return text;
}

/// Groups more than four digits in threes, starting at the decimal sign.
std::string group_digits(std::string_view digits, bool from_the_right) {
  if (digits.size() <= 4) return std::string(digits);
  std::string text;
  const std::size_t first = from_the_right ? digits.size() % 3 : 0;
  for (std::size_t k = 0; k < digits.size(); ++k) {
    if (k > 0 && (k + 3 - first) % 3 == 0) text += kNarrowSpace;
    text += digits[k];
  }
  return text;
}

/// Returns the power of ten of the leading digit after rounding to `digits` digits: −1 for 0.0996 and two digits.
int decimal_exponent(double value, int digits) {
  const std::string text = fmt::format("{:.{}e}", std::abs(value), digits - 1);
  return std::stoi(text.substr(text.find('e') + 1));
}

/// Formats with fixed decimals; a negative number of decimals rounds to tens and hundreds.
std::string format_fixed(Language language, double value, int decimals) {
  if (decimals < 0) {
    const double unit = std::pow(10.0, -decimals);
    return format_fixed(language, std::round(value / unit) * unit, 0);
  }
  const std::string magnitude = fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool is_zero = magnitude.find_first_not_of("0.") == std::string::npos;
  const auto point = std::min(magnitude.find('.'), magnitude.size());
  std::string text = value < 0 && !is_zero ? kMinus : "";
  text += group_digits(std::string_view(magnitude).substr(0, point), true);
  if (point == magnitude.size()) return text;
  return text + (language == Language::german ? "," : ".") +
         group_digits(std::string_view(magnitude).substr(point + 1), false);
}

std::string format_power_of_ten(int power) { return kTimesTenTo + superscript(power); }

/// Format of a value and its U. `decimals` applies after division by the power of ten.
struct Rounding {
  int decimals{};
  int power{};  ///< 0: none
};

Rounding choose_rounding(double value, double expanded, int digits_of_u = kDigitsOfU) {
  const int decimals = digits_of_u - 1 - decimal_exponent(expanded, digits_of_u);
  const double greatest = std::max(std::abs(value), expanded);
  const int power = decimal_exponent(greatest, kDigitsOfAValue);
  if (decimals - (digits_of_u - kDigitsOfU) <= kMostDecimals && power < kGreatestPower) return {decimals, 0};
  return {decimals + power, power};
}

/// Returns a number rounded as format_fixed() prints it after division by the power of ten.
double round_number(double number, const Rounding& rounding) {
  const double unit = std::pow(10.0, rounding.decimals - rounding.power);
  return std::round(number * unit) / unit;
}

/// Formats a value and its U with one rounding.
std::string format_rounded(Language language, const ReportedValue& value, const Rounding& rounding) {
  const double scale = std::pow(10.0, rounding.power);
  const std::string both = format_fixed(language, value.value / scale, rounding.decimals) + kPlusMinus +
                           format_fixed(language, value.expanded() / scale, rounding.decimals);
  return rounding.power == 0 ? both : "(" + both + ")" + format_power_of_ten(rounding.power);
}

bool has_expanded(const ReportedValue& value) { return std::isfinite(value.expanded()) && value.expanded() > 0; }

/// Returns the number of digits that a value needs, at most `at_most`: 1 for 0.0005, 4 for 0.123456.
int digits_needed(double value, int at_most) {
  std::string mantissa = fmt::format("{:.{}e}", std::abs(value), at_most - 1);
  mantissa.resize(mantissa.find('e'));
  std::erase(mantissa, '.');
  const auto last = mantissa.find_last_not_of('0');
  return last == std::string::npos ? 1 : static_cast<int>(last) + 1;
}

/// Numbers of a date such as "2026-11-25".
struct Day {
  int year{}, month{}, day{};
};

std::optional<Day> parse_date(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return {};
  for (const std::size_t at : {0, 1, 2, 3, 5, 6, 8, 9})
    if (!is_digit(text[at])) return {};
  const auto number = [&](std::size_t from, std::size_t length) {
    return std::stoi(std::string(text.substr(from, length)));
  };
  const Day day{number(0, 4), number(5, 2), number(8, 2)};
  if (day.month < 1 || day.month > 12 || day.day < 1 || day.day > 31) return {};
  return day;
}

constexpr std::array<std::array<const char*, 12>, 2> kMonths = {
    {{"January", "February", "March", "April", "May", "June", "July", "August", "September", "October", "November",
      "December"},
     {"Januar", "Februar", "März", "April", "Mai", "Juni", "Juli", "August", "September", "Oktober", "November",
      "Dezember"}}};

}  // namespace

FormattedValue format_parts(Language language, const ReportedValue& value) {
  if (!std::isfinite(value.value)) return {kDash, ""};
  if (!has_expanded(value)) return {format_plain(language, value.value), ""};
  const Rounding rounding = choose_rounding(value.value, value.expanded());
  const auto part = [&](double number) {
    if (rounding.power == 0) return format_fixed(language, number, rounding.decimals);
    return format_fixed(language, number / std::pow(10.0, rounding.power), rounding.decimals) +
           format_power_of_ten(rounding.power);
  };
  return {part(value.value), part(value.expanded())};
}

std::string format(Language language, const ReportedValue& value) {
  if (!std::isfinite(value.value) || !has_expanded(value)) return format_parts(language, value).value;
  return format_rounded(language, value, choose_rounding(value.value, value.expanded()));
}

std::string format_result(Language language, const ReportedValue& value) {
  const bool is_integer = value.value == std::round(value.value);
  if (!std::isfinite(value.value) || has_expanded(value) || is_integer) return format(language, value);
  return format_significant(language, value.value, kDigitsOfAValue);
}

std::string format_compared(Language language, const Conformity& conformity) {
  const ReportedValue& value = conformity.value;
  if (!std::isfinite(value.value)) return kDash;
  const auto gives_verdict = [&](const ReportedValue& printed) {
    return compare_with_limits(printed, conformity.limit, conformity.rule).verdict == conformity.verdict;
  };
  if (!has_expanded(value)) {
    int digits = kDigitsOfAValue;
    while (digits < kMostDigits &&
           !gives_verdict({.value = std::stod(fmt::format("{:.{}e}", value.value, digits - 1))}))
      ++digits;
    return format_plain(language, value.value, digits);
  }
  for (int digits = kDigitsOfU;; ++digits) {
    const Rounding rounding = choose_rounding(value.value, value.expanded(), digits);
    ReportedValue printed = value;
    printed.value = round_number(value.value, rounding);
    printed.standard_uncertainty = round_number(value.expanded(), rounding) / value.coverage_factor;
    if (digits == kMostDigits || gives_verdict(printed)) return format_rounded(language, value, rounding);
  }
}

std::string format_number(Language language, double value, int decimals) {
  return std::isfinite(value) ? format_fixed(language, value, decimals) : kDash;
}

std::string format_significant(Language language, double value, int digits) {
  assert(digits > 0);
  if (!std::isfinite(value)) return kDash;
  if (value == 0) return "0";
  const int power = decimal_exponent(value, digits);
  if (power >= kLeastPower && power < kGreatestPower) return format_fixed(language, value, digits - 1 - power);
  return format_fixed(language, value / std::pow(10.0, power), digits - 1) + format_power_of_ten(power);
}

std::string format_plain(Language language, double value, int digits) {
  if (!std::isfinite(value)) return kDash;
  if (value == std::round(value) && std::abs(value) < std::pow(10.0, kGreatestPower))
    return format_fixed(language, value, 0);
  return format_significant(language, value, digits_needed(value, digits));
}

std::string format_probability(Language language, double probability) {
  // A smaller probability would be printed as 0.0 %.
  constexpr double kMinPrintedProbability = 0.0005;
  if (!std::isfinite(probability)) return kDash;
  if (probability < kMinPrintedProbability) return "<\u00a0" + format_fixed(language, 0.1, 1) + "\u00a0%";
  if (probability > 1 - kMinPrintedProbability) return ">\u00a0" + format_fixed(language, 99.9, 1) + "\u00a0%";
  return format_fixed(language, 100 * probability, 1) + "\u00a0%";
}

std::string format_day(Language language, std::string_view day) {
  const auto found = parse_date(day);
  if (!found) return std::string(day);
  const auto* month = kMonths.at(language == Language::german ? 1 : 0).at(static_cast<std::size_t>(found->month) - 1);
  return fmt::format("{}{} {} {}", found->day, language == Language::german ? "." : "", month, found->year);
}

std::string format_instant(Language language, std::string_view utc) {
  if (utc.size() < 20 || utc[10] != 'T' || !utc.ends_with('Z') || !parse_date(utc.substr(0, 10)))
    return std::string(utc);
  return format_day(language, utc.substr(0, 10)) + ", " + std::string(utc.substr(11, 8)) + " UTC";
}

std::string format_unit(std::string_view unit) {
  if (unit == "1") return "";
  const auto first = unit.find('/');
  if (first == std::string_view::npos) return std::string(unit);
  const auto second = unit.find('/', first + 1);
  const std::string above = std::string(unit.substr(0, first)) + "/" + kWordJoiner;
  if (second == std::string_view::npos) return above + std::string(unit.substr(first + 1));
  return fmt::format("{}({}·{})", above, unit.substr(first + 1, second - first - 1), unit.substr(second + 1));
}

std::string append_unit(std::string_view number, std::string_view unit) {
  const std::string printed = format_unit(unit);
  if (printed.empty()) return std::string(number);
  const bool is_angle = printed == "°" || printed == "′" || printed == "″";
  return fmt::format("{}{}{}", number, is_angle ? "" : "\u00a0", printed);
}

std::string sensitivity_unit(std::string_view unit) {
  if (unit == "°/h") return "1";
  if (unit.empty() || unit == "1") return "°/h";
  const bool has_factors = unit.find('/') != std::string_view::npos || unit.find("·") != std::string_view::npos;
  return has_factors ? fmt::format("°/h/({})", unit) : fmt::format("°/h/{}", unit);
}

std::string remove_word_joiners(std::string text) {
  for (auto at = text.find(kWordJoiner); at != std::string::npos; at = text.find(kWordJoiner, at))
    text.erase(at, std::string_view(kWordJoiner).size());
  return text;
}

std::string name_with_unit(std::string_view name, std::string_view unit) {
  const std::string printed = format_unit(unit);
  if (printed.empty()) return std::string(name);
  if (printed.find('/') == std::string::npos) return fmt::format("{} /\u00a0{}", name, printed);
  return fmt::format("{} /\u00a0({})", name, printed);
}

}  // namespace gyrotherm::report
