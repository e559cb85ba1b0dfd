#include "plot/format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrotherm {
namespace {

constexpr const char* kMinus = "−";

std::string superscript(int n) {
  static constexpr std::array<const char*, 10> kDigits = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = n < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(n))) text += kDigits[static_cast<std::size_t>(digit - '0')];
  return text;
}

/// A number with more is written with a power of ten.
constexpr int kMostDecimals = 6;

/// Down to the second digit of the error.
int decimals_of_error(double error) { return std::max(0, 1 - static_cast<int>(std::floor(std::log10(error)))); }

}  // namespace

std::string decimal(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  const std::string magnitude = fmt::format("{:.{}f}", std::abs(value), digits);
  const bool zero = magnitude.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !zero ? kMinus + magnitude : magnitude;
}

std::string bias_text(double deg_per_h) { return decimal(deg_per_h, 4); }

std::string percent(double fraction) { return std::isfinite(fraction) ? decimal(100 * fraction, 1) + " %" : "–"; }

std::string significant(double value) {
  if (!std::isfinite(value)) return "–";
  if (value == 0) return "0";
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
  if (exponent >= 3 && exponent < 6) return decimal(value, 0);
  if (exponent >= -2 && exponent < 3) return decimal(value, 2 - exponent);
  return decimal(value / std::pow(10.0, exponent), 2) + " × 10" + superscript(exponent);
}

std::string digit_and_power(int digit, int exponent) {
  if (exponent >= -3 && exponent <= 3) return decimal(digit * std::pow(10.0, exponent), std::max(0, -exponent));
  const std::string power = "10" + superscript(exponent);
  return digit == 1 ? power : std::to_string(digit) + " × " + power;
}

std::string with_error(double value, double error) {
  if (!std::isfinite(value) || !std::isfinite(error) || error <= 0) return significant(value);
  const int decimals = decimals_of_error(error);
  if (decimals <= kMostDecimals) return decimal(value, decimals) + " ± " + decimal(error, decimals);
  const int exponent = static_cast<int>(std::floor(std::log10(std::max(std::abs(value), error))));
  const double scale = std::pow(10.0, exponent);
  const int places = std::max(0, decimals + exponent);
  return "(" + decimal(value / scale, places) + " ± " + decimal(error / scale, places) + ") × 10" +
         superscript(exponent);
}

std::string error_text(double error) {
  if (!std::isfinite(error) || error <= 0) return significant(error);
  const int decimals = decimals_of_error(error);
  return decimals <= kMostDecimals ? decimal(error, decimals) : significant(error);
}

std::string hours_text(double seconds) { return decimal(seconds / 3600, 2) + " h"; }

std::string escaped(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') safe += c;
    }
  }
  return safe;
}

}  // namespace gyrotherm
