// SPDX-License-Identifier: Apache-2.0
/// Characteristics of a gyro's bias in a thermal test, before and after compensation, each with its standard
/// uncertainty. They are the quantities of IEEE Std 647 and 952 that a fixed gyro in a chamber can provide (bias at
/// each stabilised temperature; sensitivity to temperature, to its ramp rate and to a gradient; hysteresis; retrace;
/// warm-up; turn-on to turn-on).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/dataset.hpp"
#include "core/form.hpp"

namespace gyrotherm::model {

/// A value and its standard uncertainty u, k = 1, from the noise of the record only (type A); NaN if unknown. The
/// degrees of freedom belong to u. For a mean they are the effective number of values minus one; for a combination of
/// means they follow from the Welch-Satterthwaite formula (GUM G.4.1). They are at least 1, and infinite if unknown.
struct MeasuredValue {
  double value = std::numeric_limits<double>::quiet_NaN();
  double u = std::numeric_limits<double>::quiet_NaN();
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// A value of the raw bias (before) and of the residual bias of a model (after).
struct BeforeAfter {
  MeasuredValue before, after;
};

void describe(auto& form, Like<MeasuredValue> auto& measured) {
  form("value", measured.value);
  form("u", measured.u);
  form.if_present("degrees_of_freedom", measured.degrees_of_freedom < std::numeric_limits<double>::infinity(),
                  measured.degrees_of_freedom);
}
void describe(auto& form, Like<BeforeAfter> auto& figures) {
  form("before", figures.before);
  form("after", figures.after);
}

/// Minimum length of a hold whose last hour is treated as stabilised: about twice the slowest time constant (46 min) of
/// the gyro in the reference simulation. A slower gyro, such as the virtual gyro of the default rig (100 min), has not
/// settled by then.
inline constexpr double kStabilisedHoldSeconds = 5400;

/// Hold bias: mean bias of the last hour of a stabilised hold, °/h.
struct StabilisedBias {
  int segment{};
  bool turned{};  ///< input axis reversed
  double set_point_c{};
  /// Mean of the gradient thermometers.
  double temperature_c{};
  int clusters{};
  BeforeAfter bias;
};

void describe(auto& form, Like<StabilisedBias> auto& stabilised) {
  form("segment", stabilised.segment);
  form("turned", stabilised.turned);
  form("set_point_c", stabilised.set_point_c);
  form("temperature_c", stabilised.temperature_c);
  form("clusters", stabilised.clusters);
  describe(form, stabilised.bias);
}

/// Mean bias while the block heats through a 10 K span minus the mean bias while it cools through the same span, °/h,
/// corrected by a straight line in temperature. The clusters of a pass are correlated; the uncertainty uses their
/// effective number.
struct HysteresisPoint {
  double temperature_c{};    ///< middle of the span
  int heating{}, cooling{};  ///< clusters
  BeforeAfter width;
};

void describe(auto& form, Like<HysteresisPoint> auto& point) {
  form("temperature_c", point.temperature_c);
  form("clusters_heating", point.heating);
  form("clusters_cooling", point.cooling);
  describe(form, point.width);
}

/// Hold bias minus the bias of the record's first stabilised hold at the same set point, °/h.
struct Retrace {
  int segment{};
  double set_point_c{};
  BeforeAfter change;
};

void describe(auto& form, Like<Retrace> auto& retrace) {
  form("segment", retrace.segment);
  form("set_point_c", retrace.set_point_c);
  describe(form, retrace.change);
}

/// Bias and Earth rate, separated by turning the unit around at one set point: r± = b ± Ω, so b is the mean of the two
/// rates and Ω half their difference (IEEE Std 647, bias and Earth-rate tests; a scale factor error scales Ω). Means
/// over the holds of each position cancel a steady drift if the positions alternate evenly. Other drift increases u to
/// the extent that the holds of one position differ by more than their noise.
struct TwoPosition {
  double set_point_c{};
  int as_mounted{}, turned{};  ///< holds
  BeforeAfter bias;            ///< °/h
  /// Earth rate on the input axis as mounted, °/h.
  BeforeAfter earth_rate;
  /// Earth rate in the rig file; NaN if unknown.
  double stated_earth_rate_deg_per_h = std::numeric_limits<double>::quiet_NaN();
};

void describe(auto& form, Like<TwoPosition> auto& found) {
  form("set_point_c", found.set_point_c);
  form("holds_as_mounted", found.as_mounted);
  form("holds_turned", found.turned);
  form("bias_deg_per_h", found.bias);
  form("earth_rate_deg_per_h", found.earth_rate);
  form("stated_earth_rate_deg_per_h", found.stated_earth_rate_deg_per_h);
}

/// Settling of a gyro to its final bias, in the hold in which it was switched on.
struct WarmUp {
  int segment{};
  double set_point_c{};
  /// Settling band, °/h: a 1000 s mean is settled if it differs from the final bias by at most this value. It has no
  /// standard uncertainty.
  BeforeAfter within;
  /// Time from the start of the hold after which the bias remains settled, s. It has no standard uncertainty. Unknown
  /// if the bias settles only in the last hour.
  BeforeAfter seconds;
};

void describe(auto& form, Like<WarmUp> auto& warm_up) {
  form("segment", warm_up.segment);
  form("set_point_c", warm_up.set_point_c);
  form("within_deg_per_h", warm_up.within);
  form("seconds", warm_up.seconds);
}

/// Returns text that states when the gyro was switched on: "with the run", "in segment 3".
[[nodiscard]] std::string describe_switch_on(const WarmUp& warm_up);

/// Scatter of the final biases of several starts at one set point, °/h (type A).
struct TurnOn {
  double set_point_c{};
  int starts{};
  double std_before_deg_per_h{}, std_after_deg_per_h{};
};

void describe(auto& form, Like<TurnOn> auto& turn_on) {
  form("set_point_c", turn_on.set_point_c);
  form("starts", turn_on.starts);
  form("std_before_deg_per_h", turn_on.std_before_deg_per_h);
  form("std_after_deg_per_h", turn_on.std_after_deg_per_h);
}

struct Characterisation {
  /// Bias reference, as text. Biases with different references are not compared.
  std::string zero;
  /// Text that states which holds the results are based on.
  std::string statement;
  std::vector<StabilisedBias> stabilised;
  /// Slope of the hold bias over temperature, °/h per K, common to both positions of the unit.
  BeforeAfter temperature;
  /// Reason why a short record has no sensitivity to the ramp rate and to a gradient; empty otherwise.
  std::string sensitivity_statement;
  /// Sensitivity to the temperature ramp rate, °/h per K/min, from a joint regression with the temperature. u as in
  /// data::fit_with_correlated_noise().
  BeforeAfter ramp;
  /// "A-D": the gradient that has the greatest correlation with the raw bias.
  std::string gradient;
  /// Sensitivity to this gradient, °/h per K, from a joint regression with the temperature.
  BeforeAfter of_gradient;
  /// Points in ascending order of temperature.
  std::vector<HysteresisPoint> hysteresis;
  std::vector<Retrace> retrace;
  /// One row for each set point with holds in both positions.
  std::vector<TwoPosition> two_position;
  /// One row for each stabilised hold at the start of the record or after the unit was off, if the clusters include the
  /// beginning of the hold. Empty if the record has no noise floor.
  std::vector<WarmUp> warm_ups;
};

void describe(auto& form, Like<Characterisation> auto& result) {
  form("statement", result.statement);
  form.if_present("sensitivity_statement", !result.sensitivity_statement.empty(), result.sensitivity_statement);
  form("stabilised", result.stabilised);
  form("temperature_deg_per_h_per_k", result.temperature);
  form("ramp_deg_per_h_per_k_per_min", result.ramp);
  form("gradient", result.gradient);
  form("gradient_deg_per_h_per_k", result.of_gradient);
  form("hysteresis_deg_per_h", result.hysteresis);
  form("retrace_deg_per_h", result.retrace);
  form("two_position", result.two_position);
  form("warm_ups", result.warm_ups);
}

/// Characterises a record. `residual_deg_per_h` is the residual bias of each cluster, NaN where the model refuses.
/// Results that the record cannot provide (no hold of 1.5 h, one temperature only, no ramp) are empty or unknown. The
/// three sensitivities are not independent: a ramp causes a gradient. Hysteresis before compensation includes the
/// effect of the ramp; after compensation it is hysteresis of the gyro itself or an error of the model.
[[nodiscard]] Characterisation characterise(const data::Dataset& dataset, const data::Clusters& clusters,
                                            const Eigen::VectorXd& residual_deg_per_h);

/// Computes the standard deviation of the biases at the ends of the warm-up holds, for three or more warm-ups at one
/// set point, from one record or several. All records must be characterised with one model. Only biases with the same
/// reference and position of the unit are compared; if a record's reference is the mean of its own first hold, its
/// biases are compared only with each other. Returns one row for each such set point, in ascending order.
[[nodiscard]] std::vector<TurnOn> turn_on_scatter(const std::vector<Characterisation>& records);

/// Returns the widest point of a loop; null if there is none. `which` selects the width before or after compensation.
[[nodiscard]] const HysteresisPoint* find_widest(const std::vector<HysteresisPoint>& loop,
                                                 MeasuredValue BeforeAfter::*which);

/// Least-squares coefficients with standard uncertainties that remain valid for correlated neighbouring residuals.
struct RobustFit {
  Eigen::VectorXd coefficients, u;
};

/// Fits `y` to the columns of `x` by least squares; row k has the integer position `positions`(k), in ascending order.
/// The covariance is (XᵀX)⁻¹S(XᵀX)⁻¹ with S the sum of products of scores x_k e_k up to `reach` positions apart,
/// weighted by 1 − lag/(reach + 1) (Newey, West, Econometrica 55 (1987) 703), times n/(n − p). Asserts more rows than
/// columns.
[[nodiscard]] RobustFit fit_robustly(const Eigen::MatrixXd& x, const Eigen::VectorXd& y,
                                     const Eigen::VectorXi& positions, int reach);

}  // namespace gyrotherm::model
