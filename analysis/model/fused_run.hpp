// SPDX-License-Identifier: Apache-2.0
/// Fusion of a record of many axes: a rate vector per second, the axes left out of it and the reason, and the
/// comparison with the Earth's rotation at rest.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/data/statistics.hpp"
#include "analysis/model/fault_watch.hpp"
#include "analysis/model/fused_axes.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

inline constexpr const char* kFusionSchema = "gyrotherm-fusion/1";
inline constexpr double kFusionCoverage = 2;  ///< k of every U

struct FusionOptions {
  WatchOptions watch;
  /// Leaves an axis out of all later seconds when an alarm names it. If the axes of a single second contradict each
  /// other, the isolated axis is left out of that second regardless of this option.
  bool leave_out = true;
  double cluster_s = 100;
  /// Averaging time of the means, s, for which the weights of the axes are optimal.
  double averaging_s = 100;
  /// Rates from which the limits of the cumulative sums are learnt. If missing, or if the axes differ, the limits for
  /// white noise apply.
  std::optional<HealthyRates> healthy = std::nullopt;
};

/// Inputs, uncertainty and use of one axis.
struct FusedAxisSummary {
  std::string name{}, inputs{}, method{};
  std::vector<double> direction{};
  /// Standard uncertainty of a one-second value, without the errors that training and use share.
  double second_std_deg_per_h{};
  /// Standard uncertainty of a mean over 1 h, with the errors that training and use share.
  double hour_std_deg_per_h{};
  /// Error at rest: cluster means less the Earth rate on the axis; NaN if unknown.
  double error_rms_deg_per_h{};
  /// Seconds with an input outside the trained range.
  std::int64_t outside_s{};
  /// Seconds in which the axis was left out of the rate.
  std::int64_t left_out_s{};
};

void describe(auto& form, Like<FusedAxisSummary> auto& axis) {
  form("name", axis.name);
  form("inputs", axis.inputs);
  form("method", axis.method);
  form("direction", axis.direction);
  form("second_u_deg_per_h", axis.second_std_deg_per_h);
  form("hour_u_deg_per_h", axis.hour_std_deg_per_h);
  form("error_rms_deg_per_h", axis.error_rms_deg_per_h);
  form("outside_s", axis.outside_s);
  form("left_out_s", axis.left_out_s);
}

/// A rate vector with U, k = 2, in the axes of the fixture.
struct RateVector {
  std::vector<double> deg_per_h{}, expanded_deg_per_h{};
};

void describe(auto& form, Like<RateVector> auto& rate) {
  form("deg_per_h", rate.deg_per_h);
  form("U_deg_per_h", rate.expanded_deg_per_h);
}

/// A period at rest, compared with the Earth's rotation. Uncertainties other than U are standard uncertainties.
struct RestStretch {
  std::string name{};
  double start_s{}, end_s{};
  RateVector rate{};
  /// The rate minus the Earth's rotation, in the axes of the fixture.
  std::vector<double> residual_deg_per_h{};
  /// Heading of the fixture's x axis, from north over east.
  std::optional<double> heading_deg{};
  std::optional<double> heading_expanded_deg{};  ///< U, 95 %
  /// Reason for a missing heading.
  std::string no_heading{};
  /// Rotation of the fixture from its recorded attitude, about north, east and down, and its standard uncertainty.
  std::vector<double> turn_deg{}, turn_std_deg{};
  std::vector<std::string> axes{};  ///< fused axes
  std::vector<double> bias_deg_per_h{}, bias_std_deg_per_h{};
  /// χ² of the contradiction between readings and priors, with one degree of freedom per axis, and its limit.
  double statistic{}, limit{};
};

void describe(auto& form, Like<RestStretch> auto& rest) {
  form("name", rest.name);
  form("start_s", rest.start_s);
  form("end_s", rest.end_s);
  form("rate", rest.rate);
  form("residual_deg_per_h", rest.residual_deg_per_h);
  form("heading_deg", rest.heading_deg);
  form("heading_U_deg", rest.heading_expanded_deg);
  form("no_heading", rest.no_heading);
  form("turn_north_east_down_deg", rest.turn_deg);
  form("turn_u_deg", rest.turn_std_deg);
  form("axes", rest.axes);
  form("bias_deg_per_h", rest.bias_deg_per_h);
  form("bias_u_deg_per_h", rest.bias_std_deg_per_h);
  form("chi_squared", rest.statistic);
  form("chi_squared_limit", rest.limit);
}

/// Length of the error of the rate vector: cluster means at rest compared with the Earth's rotation.
struct RateError {
  double rms_deg_per_h{};  ///< root mean square
  /// Length of the mean error.
  double mean_deg_per_h{};
  /// RMS after subtracting the mean error.
  double about_mean_deg_per_h{};
  std::int64_t clusters{};
};

void describe(auto& form, Like<RateError> auto& error) {
  form("rms_deg_per_h", error.rms_deg_per_h);
  form("mean_deg_per_h", error.mean_deg_per_h);
  form("about_mean_deg_per_h", error.about_mean_deg_per_h);
  form("clusters", error.clusters);
}

struct FusionSummary {
  bool simulated{};
  std::string run_id{}, profile{};
  std::vector<FusedAxisSummary> axes{};
  /// Averaging time of the means, s, for which the weights of the axes are optimal.
  double averaging_s{};
  /// `limit` applies to pᵀp of all axes; it is NaN without parity.
  double false_alarm_probability{}, false_alarms_per_h{}, limit{};
  /// Contradictions are seconds whose parity exceeds its limit.
  std::int64_t seconds{}, fused{}, contradictions{};
  bool thermometers_vote{};
  /// Limits at the start of the run.
  std::vector<SumLimit> sum_limits{};
  /// Latitude; NaN if unknown. The following members up to `holds` are then empty.
  double latitude_deg{};
  std::vector<double> earth_deg_per_h{};  ///< Earth rate vector, fixture axes
  std::optional<double> said_heading_deg{};
  std::optional<RateError> error{};  ///< fused rate
  /// Error of the rate computed from all axes, including those that were left out.
  std::optional<RateError> of_all_axes{};
  /// Error of the first three axes that span all directions.
  std::optional<RateError> of_three{};
  /// Fraction of the rate components (three per cluster) whose error is at most U.
  std::optional<double> within_expanded{};
  /// Joint result at rest, from the last hour of every hold.
  std::optional<RestStretch> rest{};
  std::vector<RestStretch> holds{};
  std::vector<Alarm> alarms{};
  /// Warnings about models that may belong to other axes.
  std::vector<std::string> warnings{};
};

void describe(auto& form, Like<FusionSummary> auto& summary) {
  form("simulated", summary.simulated);
  form("run_id", summary.run_id);
  form("profile", summary.profile);
  form("axes", summary.axes);
  form("averaging_s", summary.averaging_s);
  form("false_alarm_probability", summary.false_alarm_probability);
  form("false_alarms_per_h", summary.false_alarms_per_h);
  form("parity_limit", summary.limit);
  form("seconds", summary.seconds);
  form("fused", summary.fused);
  form("contradictions", summary.contradictions);
  form("thermometers_vote", summary.thermometers_vote);
  form("sum_limits", summary.sum_limits);
  form("latitude_deg", summary.latitude_deg);
  form("earth_deg_per_h", summary.earth_deg_per_h);
  form("said_heading_deg", summary.said_heading_deg);
  form("error", summary.error);
  form("error_of_all_axes", summary.of_all_axes);
  form("error_of_three_axes", summary.of_three);
  form("within_U", summary.within_expanded);
  form("rest", summary.rest);
  form("holds", summary.holds);
  form("alarms", summary.alarms);
  form("warnings", summary.warnings);
}

/// Fusion result of each second.
struct FusedRun {
  Eigen::VectorXd time_s;
  /// NaN where fewer than three axes are known, or where they lie in a plane.
  Eigen::MatrixX3d rate_deg_per_h;
  /// U of a one-second value, k = 2, including the errors that training and use share. It is increased where a fused
  /// axis had an input outside its trained range.
  Eigen::MatrixX3d expanded_deg_per_h;
  /// pᵀp of the axes; NaN with three axes.
  Eigen::VectorXd statistic;
  std::vector<AxisSet> used;  ///< fused axes; 0: none
  /// True for each second in which the statistic exceeds its limit.
  std::vector<bool> contradicts;
  /// Geometry of all axes for one second, for the parity.
  fusion::Geometry geometry;
  /// Geometry of all axes for the averaging time, for the weights.
  fusion::Geometry weights;
  FusionSummary summary;
};

/// Fuses the axes second by second, like a navigation computer: each result depends only on this second and earlier
/// ones. Axes are weighted by their uncertainty in means over `averaging_s`, without the errors that training and use
/// share. The weights are not those of a single second, because rates are averaged in use and the noise of one second
/// masks the bias of an axis. The parity test uses the uncertainty of the second itself; an isolated axis is left out
/// of that second. Cluster means are passed to the watches (fault_watch.hpp), except those of axes with an input
/// outside its trained range. When a watch names an axis or a thermometer, axes are removed from all later seconds, one
/// at a time, while each removal reduces the mean square error of the rate. For this error an axis is assumed to be off
/// by the size of its hop, or by the thermometer's fault times the mean slope of the axis's model. An alarm of a
/// cumulative sum within an hour of a vote against a thermometer does not name an axis. An alarm that follows one of
/// the same kind and name within an hour is merged with it.
///
/// At rest, in the last hour of each hold, the mean is compared with the Earth's rotation: north from the rate vector,
/// biases and rotation from fusion::estimate_at_rest(). A contradiction between readings and priors raises an alarm.
/// `thermometers` is passed to FaultWatch. Fails like make_geometry().
[[nodiscard]] Result<FusedRun> fuse(const FusedAxes& axes, const std::optional<fusion::ThermometerParity>& thermometers,
                                    const FusionOptions& options);

/// Adds the comparison with the Earth's rotation to the summary of a run. It computes the errors over all clusters,
/// since the fixture does not move in a chamber: those of the fused rate vector, of the rate vectors from all axes and
/// from three axes, and of each axis. For the last hour of each hold, and for these hours together, it estimates rate,
/// heading, biases and rotation, and raises an alarm if χ² of readings and priors exceeds its limit. Adds nothing if
/// the attitude is unknown. Each period uses the axes that were fused in at least 99 % of its seconds.
void evaluate_at_rest(const FusedAxes& axes, const FusionOptions& options, FusedRun& run);

/// Returns the cluster means of the axes in a record without faults, with NaN for axes that have an input outside their
/// trained range.
[[nodiscard]] HealthyRates healthy_rates(const FusedAxes& healthy, double cluster_s);

/// Formats the summary as a JSON file.
[[nodiscard]] std::string to_json(const FusionSummary& summary);

}  // namespace gyrotherm::model
