/// An axis, straight or logarithmic: a range with round ends, ticks in steps of 1, 2 or 5, and where a value lies on
/// it.
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

/// The same of a logarithmic axis. From the least to the greatest finite value above 0; {1, 10} if there is none.
[[nodiscard]] Range positive_range_of(const std::vector<double>& values);

/// Both ends, above 0, moved outwards to 1, 2 or 5 times a power of ten.
[[nodiscard]] Range logarithmically_rounded_out(const Range& range);

/// A tick at each digit of each decade inside the range. Powers of ten are labelled, and 2 and 5 too where the range is
/// shorter than two decades; the rest have no label.
[[nodiscard]] std::vector<Tick> logarithmic_ticks(const Range& range);

/// A map from values to pixels.
struct Scale {
  Range values;
  double from_px{};  ///< where values.low lies
  double to_px{};    ///< where values.high lies
  bool logarithmic = false;
  /// Of a logarithmic scale, values not above 0 lie where the range begins.
  [[nodiscard]] double operator()(double value) const;
};

}  // namespace gyrotherm
