// SPDX-License-Identifier: Apache-2.0
/// Control charts of one result of repeated check runs: a chart of individuals (ISO 7870-2) and an EWMA chart
/// (ISO 7870-6). Both judge the same standardised value, which takes into account that mean and standard deviation are
/// estimated from few runs.
///
/// The value of a run is compared with the mean of the n previous values and their standard deviation s of ν degrees of
/// freedom. T = (x − mean)/(s √(1 + 1/n)) has Student's distribution with ν degrees of freedom, and Q = Φ⁻¹(F_ν(T)) is
/// standard normal. In control the values Q are also independent of each other (Hawkins, Journal of Quality Technology
/// 19 (1987) 46; Quesenberry, ibid. 23 (1991) 213). The false-alarm rate is therefore exact from the first judged run
/// on.
#pragma once

#include <cstddef>
#include <vector>

namespace gyrotherm::assurance {

/// Smallest number of degrees of freedom with which a run is judged. The fifth run is therefore the first.
inline constexpr int kFewestDegrees = 3;
/// λ of the EWMA chart.
inline constexpr double kLambda = 0.2;

/// Limits of the charts in standard deviations: of Q, and of the EWMA of Q.
struct ChartLimits {
  double individuals{};
  double ewma{};
};
/// Returns the limits of one of `charts` results whose charts together have the false-alarm rate `rate` per run
/// (Bonferroni: each of the two charts of a result has rate/(2 charts)). The rate holds for any dependence between the
/// results.
[[nodiscard]] ChartLimits limits_for(double rate, std::size_t charts);

/// Scale on which values are compared. Standard deviations of ν degrees of freedom are nearly normal as the cube root
/// of the variance (Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684).
enum class ChartScale { linear, cube_root_of_variance };

/// One run on the charts.
struct ChartInput {
  double value{};  ///< NaN: not measured
  /// A new level begins with this run: the previous values no longer determine the mean, but still the deviation.
  bool starts_level{};
  /// The run was explained, so its value is not used for later limits.
  bool is_excluded{};
};

/// A run as judged by the charts. NaN if it was not judged.
struct ChartPoint {
  double value{};
  double centre{}, low{}, high{};  ///< mean and limits of the individuals chart, in the unit of the value
  double q{};
  double ewma{};  ///< EWMA of Q in units of its limit: outside ±1 is out of control
  bool is_judged{};
  bool individual_is_out{}, ewma_is_out{};
  [[nodiscard]] bool is_out() const { return individual_is_out || ewma_is_out; }
};

/// Judges the runs in order. A run that is out of control does not change later limits. The EWMA restarts at 0 with a
/// new level and after an explained run.
[[nodiscard]] std::vector<ChartPoint> judge(const std::vector<ChartInput>& runs, const ChartLimits& limits,
                                            ChartScale scale = ChartScale::linear);

}  // namespace gyrotherm::assurance
