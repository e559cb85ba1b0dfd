// SPDX-License-Identifier: Apache-2.0
#include "core/number_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace gyrotherm {

namespace {

constexpr const char* kMinus = "−";

/// Numbers with more decimals are written with a power of ten.
constexpr int kMostDecimals = 6;

/// Returns the exponent of the first digit after rounding to so many significant digits: 3 for 999.6 with 3 digits.
int rounded_exponent(double value, int digits) {
  const auto text = fmt::format("{:.{}e}", std::abs(value), digits - 1);
  return std::atoi(text.c_str() + text.find('e') + 1);
}

/// Returns the decimal place of the second digit of the error: 3 for 0.012, 0 for 12, −1 for 120.
int decimals_of_error(double error) { return 1 - rounded_exponent(error, 2); }

/// Rounds to a number of decimals, which may be negative: round_to(1234, −2) is "1200".
std::string round_to(double value, int decimals) {
  if (decimals >= 0) return decimal(value, decimals);
  const double unit = std::pow(10.0, -decimals);
  return decimal(std::round(value / unit) * unit, 0);
}

std::string with_power(double value, int exponent, int digits) {
  return decimal(value / std::pow(10.0, exponent), digits - 1) + " × 10" + superscript(exponent);
}

}  // namespace

std::string decimal(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  const std::string magnitude = fmt::format("{:.{}f}", std::abs(value), digits);
  const bool zero = magnitude.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !zero ? kMinus + magnitude : magnitude;
}

std::string superscript(int exponent) {
  static constexpr std::array<const char*, 10> kDigits = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[static_cast<std::size_t>(digit - '0')];
  return text;
}

std::string format_significant(double value) {
  constexpr int kDigits = 3, kLeastPlain = -2, kMostPlain = 5;
  if (!std::isfinite(value)) return "–";
  if (value == 0) return "0";
  const int exponent = rounded_exponent(value, kDigits);
  if (exponent < kLeastPlain || exponent > kMostPlain) return with_power(value, exponent, kDigits);
  return decimal(value, std::max(0, kDigits - 1 - exponent));
}

std::string format_digits(double value, int digits) {
  constexpr int kLeastPlain = -5, kMostPlain = 5;
  if (!std::isfinite(value)) return "–";
  if (value == 0) return "0";
  const int exponent = rounded_exponent(value, digits);
  if (exponent < kLeastPlain || exponent > kMostPlain) return with_power(value, exponent, digits);
  return decimal(value, std::max(0, digits - 1 - exponent));
}

std::string format_with_error(double value, double error) {
  if (!std::isfinite(value) || !std::isfinite(error) || error <= 0) return format_significant(value);
  const int decimals = decimals_of_error(error);
  if (decimals <= kMostDecimals) return round_to(value, decimals) + " ± " + round_to(error, decimals);
  const int exponent =
      std::max(value == 0 ? rounded_exponent(error, 2) : rounded_exponent(value, 2), rounded_exponent(error, 2));
  const double scale = std::pow(10.0, exponent);
  const int places = std::max(0, decimals + exponent);
  return "(" + decimal(value / scale, places) + " ± " + decimal(error / scale, places) + ") × 10" +
         superscript(exponent);
}

std::string with_minus_signs(std::string_view text) {
  const auto is_digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  constexpr std::string_view kBeforeNumber = " ([=:;,/";
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = i == 0 || kBeforeNumber.find(text[i - 1]) != std::string_view::npos;
    if (text[i] == '-' && begins && (is_digit(i + 1) || (i + 1 < text.size() && text[i + 1] == '.' && is_digit(i + 2))))
      result += kMinus;
    else
      result += text[i];
  }
  return result;
}

int decimals_for(double error) { return std::max(0, decimals_of_error(error)); }

std::string format_error(double error) {
  if (!std::isfinite(error) || error <= 0) return format_significant(error);
  const int decimals = decimals_of_error(error);
  return decimals <= kMostDecimals ? round_to(error, decimals) : format_significant(error);
}

}  // namespace gyrotherm
