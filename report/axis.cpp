#include "report/axis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/format.hpp"

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
