#include "report/format.hpp"

#include <fmt/format.h>

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
