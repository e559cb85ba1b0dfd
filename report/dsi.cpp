// SPDX-License-Identifier: Apache-2.0
#include "report/dsi.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace gyrotherm::report {
namespace {

struct Symbol {
  std::string_view symbol, dsi;
};

// Longer symbols come first: "°C" must not be read as "°". The symbol "g" is omitted: for gyros it is the acceleration.
constexpr std::array kSymbols = {Symbol{"°C", "\\degreecelsius"}, Symbol{"hPa", "\\hecto\\pascal"},
                                 Symbol{"kPa", "\\kilo\\pascal"}, Symbol{"mbar", "\\milli\\bar"},
                                 Symbol{"min", "\\minute"},       Symbol{"ppm", "\\ppm"},
                                 Symbol{"rad", "\\radian"},       Symbol{"kHz", "\\kilo\\hertz"},
                                 Symbol{"bar", "\\bar"},          Symbol{"mK", "\\milli\\kelvin"},
                                 Symbol{"Pa", "\\pascal"},        Symbol{"Hz", "\\hertz"},
                                 Symbol{"mA", "\\milli\\ampere"}, Symbol{"mV", "\\milli\\volt"},
                                 Symbol{"ms", "\\milli\\second"}, Symbol{"µT", "\\micro\\tesla"},
                                 Symbol{"mT", "\\milli\\tesla"},  Symbol{"mm", "\\milli\\metre"},
                                 Symbol{"kg", "\\kilogram"},      Symbol{"°", "\\degree"},
                                 Symbol{"′", "\\arcminute"},      Symbol{"″", "\\arcsecond"},
                                 Symbol{"%", "\\percent"},        Symbol{"d", "\\day"},
                                 Symbol{"h", "\\hour"},           Symbol{"s", "\\second"},
                                 Symbol{"K", "\\kelvin"},         Symbol{"V", "\\volt"},
                                 Symbol{"A", "\\ampere"},         Symbol{"W", "\\watt"},
                                 Symbol{"T", "\\tesla"},          Symbol{"m", "\\metre"}};

/// A unit raised to a power.
struct Factor {
  std::string dsi;
  double exponent = 1;
};
using Factors = std::vector<Factor>;

bool consume_prefix(std::string_view& text, std::string_view beginning) {
  if (!text.starts_with(beginning)) return false;
  text.remove_prefix(beginning.size());
  return true;
}

class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : remaining_(text) {}

  std::optional<Factors> parse() {
    auto found = quotient();
    return remaining_.empty() ? found : std::nullopt;
  }

 private:
  /// Parses factor {("/" | "·") factor}; "°/h/K" is (°/h)/K.
  std::optional<Factors> quotient() {
    auto found = factor();
    while (found) {
      const bool divides = consume_prefix(remaining_, "/");
      if (!divides && !consume_prefix(remaining_, "·")) break;
      auto next = factor();
      if (!next) return std::nullopt;
      for (Factor& one : *next) {
        if (divides) one.exponent = -one.exponent;
        found->push_back(std::move(one));
      }
    }
    return found;
  }

  /// Parses "(" quotient ")", "√" factor, or a symbol with its power.
  std::optional<Factors> factor() {
    if (consume_prefix(remaining_, "(")) {
      auto found = quotient();
      return consume_prefix(remaining_, ")") ? found : std::nullopt;
    }
    if (consume_prefix(remaining_, "√")) {
      auto found = factor();
      if (found)
        for (Factor& one : *found) one.exponent /= 2;
      return found;
    }
    for (const auto& [symbol, dsi] : kSymbols)
      if (consume_prefix(remaining_, symbol)) return Factors{{std::string(dsi), power()}};
    return std::nullopt;
  }

  double power() { return consume_prefix(remaining_, "²") ? 2 : consume_prefix(remaining_, "³") ? 3 : 1; }

  std::string_view remaining_;
};

std::string factor_text(const Factor& factor) {
  return factor.exponent == 1 ? factor.dsi : fmt::format("{}\\tothe{{{:g}}}", factor.dsi, factor.exponent);
}

/// Returns the number of decimals down to the fourth significant digit of U; negative left of the decimal point.
int decimals_for(double expanded) { return 3 - static_cast<int>(std::floor(std::log10(expanded))); }

/// Smaller numbers are written with a power of ten.
constexpr int kMostDsiDecimals = 15;

}  // namespace

std::optional<std::string> dsi_unit(std::string_view unit) {
  if (unit == "1") return "\\one";
  const auto factors = UnitParser(unit).parse();
  if (!factors) return std::nullopt;
  std::vector<Factor> above, below;
  for (const Factor& factor : *factors) (factor.exponent > 0 ? above : below).push_back(factor);
  std::string text;
  for (const Factor& factor : above) text += factor_text(factor);
  if (below.size() == 1 && !above.empty())
    return text + "\\per" + factor_text({below.front().dsi, -below.front().exponent});
  for (const Factor& factor : below) text += factor_text(factor);
  return text;
}

Certainty classify_certainty(const ReportedValue& value) {
  if (!std::isfinite(value.value)) return Certainty::nothing;
  const double expanded = value.expanded();
  if (!std::isfinite(expanded) || expanded < 0 || !(value.coverage_factor >= 1)) return Certainty::value;
  return std::isfinite(value.degrees_of_freedom) ? Certainty::with_students_u : Certainty::with_normal_u;
}

std::string dsi_number(double number) { return fmt::format("{}", number); }

std::string dsi_value(const ReportedValue& value) {
  if (classify_certainty(value) <= Certainty::value || value.expanded() == 0) return dsi_number(value.value);
  const int decimals = decimals_for(value.expanded());
  if (decimals > kMostDsiDecimals || std::abs(value.value) >= 1e15) return dsi_number(value.value);
  return fmt::format("{:.{}f}", value.value, std::max(0, decimals));
}

std::string dsi_expanded(const ReportedValue& value) {
  const double expanded = value.expanded();
  if (expanded == 0) return "0";
  const int decimals = decimals_for(expanded);
  if (decimals < 0 || decimals > kMostDsiDecimals) return dsi_number(expanded);
  const double unit = std::pow(10, decimals);
  // Rounding errors of a double must not round an integer number of units up to the next one.
  return fmt::format("{:.{}f}", std::ceil(expanded * unit * (1 - 1e-12)) / unit, decimals);
}

std::string dsi_coverage_factor(const ReportedValue& value) {
  std::string text = fmt::format("{:.10f}", value.coverage_factor);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

}  // namespace gyrotherm::report
