// SPDX-License-Identifier: Apache-2.0
/// Recognition of the same rates in two records, even if one of them was exported again with another unit, with fewer
/// decimals or as means.
#pragma once

#include <string>

#include "analysis/data/dataset.hpp"
#include "core/form.hpp"

namespace gyrotherm::data {

/// The rates of a record as means over equal intervals, from the first row of the period on.
struct RateTrace {
  /// The length of an interval; 0 if there is no trace.
  double interval_s{};
  /// The mean of the first interval with a rate, and the step of `means`, an eighth of their scatter.
  double first_deg_per_h{}, step_deg_per_h{};
  /// Two characters per interval: the mean minus the first one, in steps, modulo 4095, in base 64. "//" marks an
  /// interval without a rate.
  std::string means{};
  bool operator==(const RateTrace&) const = default;
};

void describe(auto& form, Like<RateTrace> auto& trace) {
  form("interval_s", trace.interval_s);
  form("first_deg_per_h", trace.first_deg_per_h);
  form("step_deg_per_h", trace.step_deg_per_h);
  form("means", trace.means);
}

/// Returns the means of the rates from `from_s` to `to_s`: at most 4096, over 1, 2, 5, 10, … times the spacing of the
/// rows. Returns an empty trace for fewer than 40 rows and for a constant rate.
[[nodiscard]] RateTrace trace_rates(const Dataset& dataset, double from_s, double to_s);

/// Returns whether the dataset has rates of the record of the trace from `from_s` to `to_s`, at whatever time, and with
/// whatever rounding or averaging.
///
/// Both are averaged over windows of equal length. Fourth differences of the means remove the slow part, which two runs
/// of the same profile have in common, and leave the noise. The noise of independent runs is not correlated. At least
/// 40 windows that are known in both must have a correlation above 0.7 which is more than 7 standard deviations of the
/// correlation of independent noise with these autocorrelations. Level and scatter must agree, too.
[[nodiscard]] bool has_rates_of(const Dataset& dataset, const RateTrace& trace, double from_s, double to_s);

}  // namespace gyrotherm::data
