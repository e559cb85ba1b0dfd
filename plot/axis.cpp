#include "plot/axis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plot/format.hpp"

namespace gyrotherm {
namespace {

/// A tick within this part of a step of the range's end counts as on it.
constexpr double kRounding = 1e-6;

Range moved_out(const Range& range, double step) {
  const Range out{step * std::floor(range.low / step + kRounding), step * std::ceil(range.high / step - kRounding)};
  return out.high > out.low ? out : Range{out.low - step, out.low + step};
}

}  // namespace

Range range_of(const std::vector<double>& values) {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    range = {std::min(range.low, value), std::max(range.high, value)};
  }
  return range.low <= range.high ? range : Range{0, 1};
}

Range joined(const Range& a, const Range& b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }

double tick_step(const Range& range, int count) {
  const double width = range.high > range.low ? range.high - range.low : 1.0;
  const double rough = width / count;
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  const double digit = rough / decade;
  return decade * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

Range rounded_out(const Range& range, int count) {
  double step = tick_step(range, count);
  Range out = moved_out(range, step);
  // The wider range may ask for wider steps, whose ticks its ends must meet.
  while (tick_step(out, count) > step * (1 + kRounding)) {
    step = tick_step(out, count);
    out = moved_out(range, step);
  }
  return out;
}

Range positive_range_of(const std::vector<double>& values) {
  Range range{std::numeric_limits<double>::infinity(), 0};
  for (const double value : values) {
    if (!std::isfinite(value) || value <= 0) continue;
    range = {std::min(range.low, value), std::max(range.high, value)};
  }
  return range.low <= range.high ? range : Range{1, 10};
}

Range logarithmically_rounded_out(const Range& range) {
  const auto rounded = [](double value, bool up) {
    const double decade = std::pow(10.0, std::floor(std::log10(value) + kRounding));
    const double digit = value / decade;
    if (up) return decade * (digit <= 1 + kRounding ? 1 : digit <= 2 + kRounding ? 2 : digit <= 5 + kRounding ? 5 : 10);
    return decade * (digit < 2 - kRounding ? 1 : digit < 5 - kRounding ? 2 : 5);
  };
  const Range out{rounded(range.low, false), rounded(range.high, true)};
  return out.high > out.low ? out : Range{out.low, 10 * out.low};
}

std::vector<Tick> logarithmic_ticks(const Range& range) {
  constexpr double kShort = 100;  // two decades
  const bool label_all = range.high < kShort * range.low;
  std::vector<Tick> all;
  const int last = static_cast<int>(std::floor(std::log10(range.high) + kRounding));
  for (int exponent = static_cast<int>(std::floor(std::log10(range.low))); exponent <= last; ++exponent) {
    for (int digit = 1; digit < 10; ++digit) {
      const double value = digit * std::pow(10.0, exponent);
      if (value < range.low * (1 - kRounding) || value > range.high * (1 + kRounding)) continue;
      const bool labelled = digit == 1 || (label_all && (digit == 2 || digit == 5));
      all.push_back({value, labelled ? digit_and_power(digit, exponent) : ""});
    }
  }
  return all;
}

double Scale::operator()(double value) const {
  const auto along = [&](double low, double at, double high) {
    return from_px + (at - low) / (high - low) * (to_px - from_px);
  };
  if (!logarithmic) return along(values.low, value, values.high);
  if (!(value > 0)) return std::isnan(value) ? value : from_px;
  return along(std::log(values.low), std::log(value), std::log(values.high));
}

std::vector<Tick> ticks(const Range& range, int count) {
  const double step = tick_step(range, count);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + kRounding)));
  const auto first = std::llround(std::ceil(range.low / step - kRounding));
  const auto last = std::llround(std::floor(range.high / step + kRounding));
  std::vector<Tick> all;
  for (auto k = first; k <= last; ++k) {
    const double value = static_cast<double>(k) * step;
    all.push_back({value, decimal(value, decimals)});
  }
  return all;
}

}  // namespace gyrotherm
