/// An axis: a range with round ends, ticks in steps of 1, 2 or 5, and where a value lies on it.
#pragma once

#include <string>
#include <vector>

namespace gyrotherm {

struct Range {
  double low{};
  double high{};
};

struct Tick {
  double value{};
  std::string label;
};

/// From the least to the greatest finite value; {0, 1} if there is none.
[[nodiscard]] Range range_of(const std::vector<double>& values);

/// The range that holds both.
[[nodiscard]] Range joined(const Range& a, const Range& b);

/// The step of 1, 2 or 5 times a power of ten that cuts the range into about `count` parts. A range without width
/// counts as 1.
[[nodiscard]] double tick_step(const Range& range, int count);

/// The range with both ends moved outwards to a tick of about `count` that ticks() then finds again.
[[nodiscard]] Range rounded_out(const Range& range, int count);

/// The ticks inside the range, ends included, each labelled with as many decimals as the step needs.
[[nodiscard]] std::vector<Tick> ticks(const Range& range, int count);

/// A linear map from values to pixels.
struct Scale {
  Range values;
  double from_px{};  ///< where values.low lies
  double to_px{};    ///< where values.high lies
  [[nodiscard]] double operator()(double value) const {
    return from_px + (value - values.low) / (values.high - values.low) * (to_px - from_px);
  }
};

}  // namespace gyrotherm
