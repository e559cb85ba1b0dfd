// SPDX-License-Identifier: Apache-2.0
/// What a laboratory reports of a gyro's bias in a thermal test, before and after compensation, each figure with its
/// standard uncertainty: the lists of IEEE Std 647 and 952 as far as a fixed gyro in a chamber can give them (bias at
/// each stabilised temperature; sensitivity to temperature, to its ramp and to a gradient; hysteresis; retrace;
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

/// A figure and its standard uncertainty, k = 1, of the record's own noise alone (type A); NaN: not known. The degrees
/// of freedom are those of u: of a mean its effective number of values less one, of what is made of several means by
/// Welch and Satterthwaite (GUM G.4.1), and at least 1; infinite where they are not known.
struct Measured {
  double value = std::numeric_limits<double>::quiet_NaN();
  double u = std::numeric_limits<double>::quiet_NaN();
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

/// The same figure of the raw bias and of what a model leaves of it.
struct BeforeAfter {
  Measured before, after;
};

void describe(auto& form, Like<Measured> auto& measured) {
  form("value", measured.value);
  form("u", measured.u);
  form.if_there("degrees_of_freedom", measured.degrees_of_freedom < std::numeric_limits<double>::infinity(),
                measured.degrees_of_freedom);
}
void describe(auto& form, Like<BeforeAfter> auto& figures) {
  form("before", figures.before);
  form("after", figures.after);
}

/// A hold this long counts as stabilised in its last hour: two of the slowest time constants of the reference
/// simulation's gyro (46 min). One that is slower, as the default rig's (100 min), has not come to rest by then.
inline constexpr double kStabilisedHoldSeconds = 5400;

/// Mean bias over the last hour of a stabilised hold, °/h.
struct StabilisedBias {
  int segment{};
  bool turned{};  ///< the unit's input axis pointed the other way
  double set_point_c{};
  double temperature_c{};  ///< mean of the gradient thermometers
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

/// Mean bias while the block heats through a span of 10 K, less that while it cools through it, °/h, beside a straight
/// line in temperature. A pass through the span lasts many clusters, which are alike: they count by their effective
/// number.
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

/// Stabilised bias less that of the record's first stabilised hold, at the same set point, °/h.
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

/// Bias and Earth's rate told apart by turning the unit around at one set point: r± = b ± Ω, so b is the mean of the
/// two and Ω half their difference (IEEE Std 647, bias and Earth-rate tests; a scale factor's error goes with Ω).
/// Means over the holds of each position, so that a steady drift cancels where they take turns evenly; what does not is
/// in u as far as the holds of one position differ by more than their noise.
struct TwoPosition {
  double set_point_c{};
  int as_mounted{}, turned{};                                                     ///< holds
  BeforeAfter bias;                                                               ///< °/h
  BeforeAfter earth_rate;                                                         ///< °/h on the input axis as mounted
  double stated_earth_rate_deg_per_h = std::numeric_limits<double>::quiet_NaN();  ///< by the rig file; NaN: not known
};

void describe(auto& form, Like<TwoPosition> auto& found) {
  form("set_point_c", found.set_point_c);
  form("holds_as_mounted", found.as_mounted);
  form("holds_turned", found.turned);
  form("bias_deg_per_h", found.bias);
  form("earth_rate_deg_per_h", found.earth_rate);
  form("stated_earth_rate_deg_per_h", found.stated_earth_rate_deg_per_h);
}

/// How a gyro that was switched on comes to its final bias, in the hold that it was switched on in.
struct WarmUp {
  int segment{};
  double set_point_c{};
  BeforeAfter within;  ///< °/h: nearer than this, a mean over 1000 s counts as final; its u is not given
  BeforeAfter
      seconds;  ///< after which it stays so near; its u is not given. Not known if it comes there in the last hour
};

void describe(auto& form, Like<WarmUp> auto& warm_up) {
  form("segment", warm_up.segment);
  form("set_point_c", warm_up.set_point_c);
  form("within_deg_per_h", warm_up.within);
  form("seconds", warm_up.seconds);
}

/// When the gyro was switched on, in words: "with the run", "in segment 3".
[[nodiscard]] std::string switched_on(const WarmUp& warm_up);

/// How much the final biases of several starts at one set point differ, °/h (type A).
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
  std::string zero;       ///< what its biases are counted from, in words; of different zeros none are compared
  std::string statement;  ///< what it was made of, in words
  std::vector<StabilisedBias> stabilised;
  BeforeAfter temperature;                  ///< °/h per K: slope of the straight line through the stabilised biases,
                                            ///< one line for each position
  BeforeAfter ramp;                         ///< °/h per K/min, beside a straight line in temperature
  std::string gradient;                     ///< "A-D": the gradient whose correlation with the raw bias is greatest
  BeforeAfter of_gradient;                  ///< °/h per K, beside a straight line in temperature
  std::vector<HysteresisPoint> hysteresis;  ///< by rising temperature
  std::vector<Retrace> retrace;
  std::vector<TwoPosition> two_position;  ///< a row for each set point at which there are both positions
  std::vector<WarmUp> warm_ups;           ///< of stabilised holds that the record begins with, or before which the unit
                                          ///< was off, if the clusters have them from their beginning; none if the
                                          ///< record has no noise floor
};

void describe(auto& form, Like<Characterisation> auto& result) {
  form("statement", result.statement);
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

/// Characterises a record; `residual_deg_per_h` is what a model leaves of each cluster, NaN where it refuses. What the
/// record cannot give (no hold of 1.5 h, one temperature only, no ramp) is empty or not known. The three sensitivities
/// are not independent of each other: a ramp makes a gradient. Hysteresis before compensation holds what the ramp does;
/// what is left of it after is the gyro's own, or the model's failure.
[[nodiscard]] Characterisation characterise(const data::Dataset& dataset, const data::Clusters& clusters,
                                            const Eigen::VectorXd& residual_deg_per_h);

/// Of three or more warm-ups at one set point, of one record or several: the standard deviation of the biases at the
/// ends of their holds. The records are characterised by one model. Only biases that are counted from one zero, and of
/// one position of the unit, are compared: where a record's zero is the mean of its own first hold, those of this
/// record alone. A row for each set point at which there are as many, by rising set point.
[[nodiscard]] std::vector<TurnOn> turn_on_of(const std::vector<Characterisation>& records);

/// The widest point of a loop, before or after compensation; null if there is none.
[[nodiscard]] const HysteresisPoint* widest(const std::vector<HysteresisPoint>& loop, Measured BeforeAfter::*which);

/// Coefficients of least squares with standard uncertainties that hold where neighbouring residuals are alike.
struct RobustFit {
  Eigen::VectorXd coefficients, u;
};

/// Least squares of `y` on the columns of `x`, row k at the whole place `places`(k), rising. The covariance is
/// (XᵀX)⁻¹S(XᵀX)⁻¹ with S the sum of products of scores x_k e_k up to `reach` places apart, weighted by 1 − lag/(reach
/// + 1) (Newey, West, Econometrica 55 (1987) 703), times n/(n − p). Asserts more rows than columns.
[[nodiscard]] RobustFit fit_robustly(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::VectorXi& places,
                                     int reach);

}  // namespace gyrotherm::model
