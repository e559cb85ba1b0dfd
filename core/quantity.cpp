// SPDX-License-Identifier: Apache-2.0
#include "core/quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm {
namespace {

struct Quantity {
  double value;
  std::string unit;
};

/// Removes a number and its unit from the start of `text`. The unit extends to the next number or the end.
std::optional<Quantity> take_quantity(std::string_view& text) {
  text = trimmed(text);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  text = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
  const auto length = std::min(text.find_first_of("0123456789+-."), text.size());
  Quantity q{value, std::string(trimmed(text.substr(0, length)))};
  text = trimmed(text.substr(length));
  return q;
}

}  // namespace

std::optional<double> parse_quantity(std::string_view text, std::span<const std::string_view> units) {
  const auto q = take_quantity(text);
  if (!q || !text.empty()) return std::nullopt;
  if (std::find(units.begin(), units.end(), q->unit) == units.end()) return std::nullopt;
  return q->value;
}

Result<Duration> parse_duration(std::string_view whole) {
  constexpr std::array<std::pair<std::string_view, double>, 5> kUnits{
      {{"ms", 1e-3}, {"s", 1}, {"min", 60}, {"h", 3600}, {"d", 86400}}};
  auto rest = trimmed(whole);
  double seconds = 0;
  bool any = false;
  while (!rest.empty()) {
    const auto q = take_quantity(rest);
    const auto* unit =
        q ? std::find_if(kUnits.begin(), kUnits.end(), [&](auto& u) { return u.first == q->unit; }) : kUnits.end();
    if (unit == kUnits.end() || q->value < 0) {
      any = false;
      break;
    }
    seconds += q->value * unit->second;
    any = true;
  }
  constexpr double kLongest_s = 1e8;
  if (any && seconds > kLongest_s)
    return failure(FaultKind::bad_file, "",
                   fmt::format("\"{}\" is too long; expected at most {:.0f} h", whole, std::floor(kLongest_s / 3600)));
  if (!any)
    return failure(FaultKind::bad_file, "",
                   fmt::format("\"{}\" is not a duration; expected text like \"2 h\", \"90 s\"", whole));
  return from_seconds(seconds);
}

}  // namespace gyrotherm
