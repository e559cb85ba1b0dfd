// SPDX-License-Identifier: Apache-2.0
/// A record of many axes fused: a rate vector a second, who was left out of it and why, and what the Earth's rotation
/// says of it at rest.
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
inline constexpr double kFusionCoverage = 2;  ///< k of every U of a fused rate

struct FusionOptions {
  WatchOptions watch;
  bool leave_out = true;  ///< an axis that was named, from then on; a second that contradicts itself loses one anyway
  double cluster_s = 100;
  double averaging_s = 100;  ///< means that axes are weighed for
  /// The limits of the cumulative sums are learnt from these if the axes are the same; else they are those of white
  /// noise.
  std::optional<HealthyRates> healthy = std::nullopt;
};

/// One axis as it went in.
struct FusedAxisSummary {
  std::string name{}, inputs{}, method{};
  std::vector<double> direction{};
  double second_std_deg_per_h{};  ///< u of a second, without what training and use have in common
  double hour_std_deg_per_h{};    ///< u of a mean over 1 h, with it
  double error_rms_deg_per_h{};   ///< at rest: of cluster means less the Earth's rate on it; NaN: not known
  std::int64_t outside_s{};       ///< seconds with an input beyond the trained range
  std::int64_t left_out_s{};      ///< seconds in which it had no part in the rate
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

/// A stretch at rest, and what the Earth's rotation says of it. Uncertainties are standard ones but for U.
struct RestStretch {
  std::string name{};  ///< of the segment
  double start_s{}, end_s{};
  RateVector rate{};
  std::vector<double> residual_deg_per_h{};      ///< the rate less the Earth's, in the fixture
  std::optional<double> heading_deg{};           ///< of the fixture's x axis, from north over east
  std::optional<double> heading_expanded_deg{};  ///< U, 95 %
  std::string no_heading{};                      ///< why it could not be found
  /// About north, east and down: how the fixture stands beside what the record says; and its standard uncertainty.
  std::vector<double> turn_deg{}, turn_std_deg{};
  std::vector<std::string> axes{};  ///< those that were fused
  std::vector<double> bias_deg_per_h{}, bias_std_deg_per_h{};
  double statistic{}, limit{};  ///< of readings and priors against each other; χ² with a degree of freedom per axis
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

/// The length of the error of a rate vector, of cluster means at rest against the Earth's rotation.
struct RateError {
  double rms_deg_per_h{};         ///< √ of the mean of its square
  double mean_deg_per_h{};        ///< length of the mean error
  double about_mean_deg_per_h{};  ///< RMS of what is left without that
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
  double averaging_s{};                                             ///< means that axes are weighed for
  double false_alarm_probability{}, false_alarms_per_h{}, limit{};  ///< limit: of pᵀp of all axes; NaN: no parity
  std::int64_t seconds{}, fused{}, contradictions{};  ///< contradictions: seconds whose parity is above its limit
  bool thermometers_vote{};
  std::vector<SumLimit> sum_limits{};     ///< at the start of the run
  double latitude_deg{};                  ///< NaN: not known, and what follows is empty
  std::vector<double> earth_deg_per_h{};  ///< in the fixture
  std::optional<double> said_heading_deg{};
  std::optional<RateError> error{};         ///< of the fused rate
  std::optional<RateError> of_all_axes{};   ///< as if none were ever left out
  std::optional<RateError> of_three{};      ///< of the first three axes that see all directions
  std::optional<double> within_expanded{};  ///< share of the components of cluster means within their U
  std::optional<RestStretch> rest{};        ///< of the last hours of all holds together
  std::vector<RestStretch> holds{};
  std::vector<Alarm> alarms{};
  std::vector<std::string> warnings{};  ///< models that may not be of these axes
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

/// What fusion made of each second.
struct FusedRun {
  Eigen::VectorXd time_s;
  Eigen::MatrixX3d rate_deg_per_h;  ///< NaN where fewer than three axes are known, or they lie in a plane
  /// U of a second, k = 2, with what training and use have in common; wider where an axis that was used had an input
  /// beyond its trained range.
  Eigen::MatrixX3d expanded_deg_per_h;
  Eigen::VectorXd statistic;      ///< pᵀp of the axes that were asked; NaN of three
  std::vector<AxisSet> used;      ///< who made the rate; 0: nobody
  std::vector<bool> contradicts;  ///< the statistic is above its limit
  fusion::Geometry geometry;      ///< all axes, one second: parity
  fusion::Geometry weights;       ///< all axes, averaging time: weights
  FusionSummary summary;
};

/// Fuses the axes second by second, as a navigation computer would: what is known of a second comes of it and of those
/// before. A second's axes are weighted by their uncertainty in means over `averaging_s`, without what training
/// and use have in common: a rate is used in means, and in a second noise hides which axis is biased. Their parity is
/// tested by the uncertainty of that second, and one that is isolated has no part in that second. Means over clusters,
/// but those of axes with an input beyond its trained range, go through the watches (fault_watch.hpp). If one is named,
/// axes are left out from then on as long as that makes the mean square error of the rate less: by how much each is
/// then off is the size of its hop, or of a thermometer's fault by its model's mean slope. What a sum says within an
/// hour of a vote against a thermometer names nobody. Alarms of one kind and of the same name that follow within an
/// hour are one.
///
/// At rest, in the last hour of each hold, the mean is held against the Earth's rotation: north of the rate vector,
/// biases and turn by fusion::at_rest(); an alarm where readings and priors contradict each other. `thermometers`: as
/// of FaultWatch. Fails as geometry_of() does.
[[nodiscard]] Result<FusedRun> fuse(const FusedAxes& axes, const std::optional<fusion::ThermometerParity>& thermometers,
                                    const FusionOptions& options);

/// Adds to the summary of a run what the Earth's rotation says of it: the error of the rate vector over all clusters
/// (the fixture does not move in a chamber), that of all axes and of three of them alone, and of each axis; and of the
/// last hour of each hold, and of all of these together, rate, heading, biases and turn, and an alarm where χ² of
/// readings and priors is above its limit. Adds nothing if the attitude is not known. A stretch counts the axes that
/// had a part in all of the rate there.
void judge_at_rest(const FusedAxes& axes, const FusionOptions& options, FusedRun& run);

/// Returns the cluster means of the axes in a record in which nothing is at fault, without those of axes that have an
/// input beyond its trained range.
[[nodiscard]] HealthyRates healthy_rates(const FusedAxes& healthy, double cluster_s);

/// The summary as a file.
[[nodiscard]] std::string to_json(const FusionSummary& summary);

}  // namespace gyrotherm::model
