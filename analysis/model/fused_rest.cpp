// SPDX-License-Identifier: Apache-2.0
/// Compares a fused record at rest with the Earth's rotation (second part of fused_run.hpp).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "analysis/data/distributions.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "analysis/fusion/rest.hpp"
#include "analysis/model/fused_run.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::vector<double> to_numbers(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

std::optional<RateError> rate_error(const Eigen::MatrixX3d& rates, const Eigen::Vector3d& earth) {
  RateError error;
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double squares = 0;
  for (Eigen::Index k = 0; k < rates.rows(); ++k) {
    if (!rates.row(k).allFinite()) continue;
    const Eigen::RowVector3d deviation = rates.row(k) - earth.transpose();
    sum += deviation;
    squares += deviation.squaredNorm();
    ++error.clusters;
  }
  if (error.clusters == 0) return std::nullopt;
  const auto count = static_cast<double>(error.clusters);
  error.rms_deg_per_h = std::sqrt(squares / count);
  error.mean_deg_per_h = (sum / count).norm();
  error.about_mean_deg_per_h = std::sqrt(std::max(0.0, squares / count - std::pow(error.mean_deg_per_h, 2)));
  return error;
}

/// Returns the first three axes, in order, that span all directions.
AxisSet find_first_three(const FusedAxes& axes, const Eigen::MatrixXd& covariance) {
  for (Eigen::Index a = 0; a < axes.axes(); ++a)
    for (Eigen::Index b = a + 1; b < axes.axes(); ++b)
      for (Eigen::Index c = b + 1; c < axes.axes(); ++c) {
        const AxisSet set = (AxisSet{1} << static_cast<unsigned>(a)) | (AxisSet{1} << static_cast<unsigned>(b)) |
                            (AxisSet{1} << static_cast<unsigned>(c));
        if (geometry_of_set(axes, set, covariance)) return set;
      }
  return 0;
}

Eigen::MatrixX3d fuse_set(const FusedAxes& axes, AxisSet set, const Eigen::MatrixXd& covariance,
                          const Eigen::MatrixXd& readings) {
  const auto geometry = geometry_of_set(axes, set, covariance);
  if (!geometry) return Eigen::MatrixX3d::Constant(0, 3, 0);
  return readings(Eigen::all, members(set)) * compute_gains(*geometry).rate.transpose();
}

/// Rows of one period at rest, and the axes that were fused in at least 99 % of them.
struct Stretch {
  std::string name;
  std::vector<Eigen::Index> rows;
  AxisSet set{};
};

/// Returns the last hour of each hold, restricted to seconds with a rate.
std::vector<Stretch> find_stretches(const FusedAxes& axes, const FusedRun& run) {
  constexpr std::size_t kFewestSeconds = 600;
  std::vector<Stretch> stretches;
  for (std::size_t segment = 0; segment < axes.segments.size(); ++segment) {
    if (!axes.segments[segment].hold) continue;
    Stretch stretch{.name = axes.segments[segment].name, .rows = {}, .set = ~AxisSet{0}};
    for (Eigen::Index row = 0; row < axes.segment.size(); ++row)
      if (axes.segment(row) == static_cast<int>(segment) && run.used[static_cast<std::size_t>(row)] != 0)
        stretch.rows.push_back(row);
    const auto quiet = static_cast<std::size_t>(data::kQuietSeconds);
    if (stretch.rows.size() > quiet)
      stretch.rows.erase(stretch.rows.begin(), stretch.rows.end() - static_cast<std::ptrdiff_t>(quiet));
    if (stretch.rows.size() < kFewestSeconds) continue;
    // A few contradictory seconds do not remove an axis from the period.
    std::size_t used_seconds = 0;
    for (Eigen::Index a = 0; a < axes.axes(); ++a) {
      const auto has = [&](Eigen::Index row) {
        return (run.used[static_cast<std::size_t>(row)] >> static_cast<unsigned>(a) & 1) != 0;
      };
      used_seconds = static_cast<std::size_t>(std::ranges::count_if(stretch.rows, has));
      if (used_seconds * 100 < stretch.rows.size() * 99) stretch.set &= ~(AxisSet{1} << static_cast<unsigned>(a));
    }
    stretch.set &= (AxisSet{1} << static_cast<unsigned>(axes.axes() - 1)) |
                   ((AxisSet{1} << static_cast<unsigned>(axes.axes() - 1)) - 1);
    stretches.push_back(std::move(stretch));
  }
  return stretches;
}

/// Returns the rate in a level frame: the first axis has the fixture's heading, the third points down.
fusion::FusedRate rotate_to_level(const fusion::FusedRate& rate, const fusion::Attitude& attitude, double heading_deg) {
  const Eigen::Matrix3d turn = fusion::level_fixture(heading_deg).transpose() * attitude.to_local;
  return {turn * rate.deg_per_h, turn * rate.covariance * turn.transpose()};
}

double recorded_heading(const fusion::Attitude& attitude) {
  return std::atan2(attitude.to_local(1, 0), attitude.to_local(0, 0)) * kDegrees;
}

void add_heading(RestStretch& rest, const fusion::FusedRate& rate, const fusion::Attitude& attitude) {
  const Eigen::Matrix3d turns = pose_covariance(attitude);
  const fusion::Tilt tilt{.about_north_deg = kDegrees * std::sqrt(turns(0, 0)),
                          .about_east_deg = kDegrees * std::sqrt(turns(1, 1))};
  const auto north =
      find_north(rotate_to_level(rate, attitude, recorded_heading(attitude)), attitude.latitude_deg, tilt);
  if (!north) {
    rest.no_heading = north.error().what;
    return;
  }
  rest.heading_deg = north->heading_deg;
  rest.heading_expanded_deg = north->expanded_deg;
}

void add_estimate(RestStretch& rest, const fusion::RestEstimate& estimate, double false_alarm_probability) {
  rest.turn_deg = to_numbers(kDegrees * estimate.rotation_rad);
  rest.turn_std_deg = to_numbers(kDegrees * estimate.rotation_covariance.diagonal().cwiseSqrt());
  rest.bias_deg_per_h = to_numbers(estimate.bias_deg_per_h);
  rest.bias_std_deg_per_h = to_numbers(estimate.bias_covariance.diagonal().cwiseMax(0).cwiseSqrt());
  rest.statistic = estimate.statistic;
  rest.limit = data::chi_squared_limit(false_alarm_probability, static_cast<double>(estimate.bias_deg_per_h.size()));
}

/// Returns no value if the axes of the period do not span all directions.
std::optional<RestStretch> evaluate_stretch(const FusedAxes& axes, const Stretch& stretch,
                                            const FusionOptions& options) {
  const fusion::Attitude& attitude = *axes.attitude;
  const std::vector<Eigen::Index> in = members(stretch.set);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(std::ssize(in)), added = mean;
  double count = 0;
  for (const Eigen::Index row : stretch.rows) {
    const Eigen::VectorXd readings = axes.rate_deg_per_h.row(row)(in).transpose();
    if (!readings.allFinite()) continue;
    mean += readings;
    added += axes.added_variance.row(row)(in).transpose();
    ++count;
  }
  const FusedUncertainty uncertainty = uncertainty_of_means(axes, std::max(1.0, count));
  const auto geometry = geometry_of_set(axes, stretch.set, uncertainty.varying_covariance());
  if (!geometry || count == 0) return std::nullopt;
  mean /= count;
  added /= count;
  const fusion::Gains gains = compute_gains(*geometry);
  fusion::FusedRate rate = fuse_readings(gains, mean);
  rate.covariance = rate_covariance(gains, uncertainty.learnt(in, in), added);
  RestStretch rest{.name = stretch.name,
                   .start_s = axes.time_s(stretch.rows.front()),
                   .end_s = axes.time_s(stretch.rows.back()) + 1};
  rest.axes = geometry->names;
  rest.rate = {to_numbers(rate.deg_per_h), to_numbers(kFusionCoverage * rate.covariance.diagonal().cwiseSqrt())};
  rest.residual_deg_per_h = to_numbers(rate.deg_per_h - earth_in_fixture(attitude));
  add_heading(rest, rate, attitude);
  fusion::Geometry reading = *geometry;
  reading.covariance = uncertainty.noise(in).asDiagonal();
  const Eigen::MatrixXd bias = uncertainty.bias(in, in) + Eigen::MatrixXd(added.asDiagonal());
  const auto estimate = estimate_at_rest(reading, mean, attitude,
                                         {.mean_deg_per_h = Eigen::VectorXd::Zero(std::ssize(in)), .covariance = bias});
  if (estimate) add_estimate(rest, *estimate, options.watch.false_alarm_probability);
  return rest;
}

/// Raises an alarm that does not name an axis: each axis, together with a rotation, could explain the contradiction
/// between readings and priors.
void add_alarm(const RestStretch& rest, std::vector<Alarm>& alarms) {
  if (rest.bias_deg_per_h.empty() || rest.statistic <= rest.limit) return;
  alarms.push_back({.kind = AlarmKind::rest,
                    .at_s = rest.end_s,
                    .since_s = rest.start_s,
                    .until_s = rest.end_s,
                    .statement = fmt::format("χ² {:.3g} of {}, limit {:.3g}: at rest ({}) the axes differ from the "
                                             "Earth rate by more than the budgets of their models",
                                             rest.statistic, rest.bias_deg_per_h.size(), rest.limit, rest.name)});
}

/// Returns the share of the components of cluster means whose error is within U, computed for the axes that were fused
/// in the last second of the cluster. Outside the trained range of an axis, U includes the variance that is added
/// there.
std::optional<double> share_within(const FusedAxes& axes, const FusionOptions& options, const ClusterMeans& means,
                                   const FusedRun& run) {
  const FusedUncertainty uncertainty = uncertainty_of_means(axes, options.cluster_s);
  const Eigen::MatrixXd weight_covariance = uncertainty_of_means(axes, options.averaging_s).varying_covariance();
  const Eigen::MatrixXd added = cluster_means(axes.time_s, axes.added_variance, options.cluster_s).mean;
  const Eigen::RowVector3d earth = earth_in_fixture(*axes.attitude).transpose();
  std::map<AxisSet, std::optional<fusion::Gains>> gains_of_set;
  double within = 0, known = 0;
  for (Eigen::Index k = 0; k < means.end_s.size(); ++k) {
    if (!means.mean.row(k).allFinite()) continue;
    const auto last = std::ranges::lower_bound(run.time_s, means.end_s(k)) - run.time_s.begin() - 1;
    const AxisSet set = run.used[static_cast<std::size_t>(last)];
    const auto [at, is_new] = gains_of_set.try_emplace(set);
    if (is_new) {
      const auto geometry = geometry_of_set(axes, set, uncertainty.varying_covariance());
      const auto weights = geometry_of_set(axes, set, weight_covariance);
      if (geometry && weights) at->second = weighted_gains(*geometry, *weights);
    }
    known += 3;
    if (!at->second) continue;
    const auto in = members(set);
    const Eigen::Matrix3d covariance =
        rate_covariance(*at->second, uncertainty.learnt(in, in), added.row(k)(in).transpose());
    const Eigen::RowVector3d expanded = kFusionCoverage * covariance.diagonal().cwiseSqrt().transpose();
    within += static_cast<double>(((means.mean.row(k) - earth).cwiseAbs().array() <= expanded.array()).count());
  }
  return known > 0 ? std::optional(within / known) : std::nullopt;
}

void evaluate_errors(const FusedAxes& axes, const FusionOptions& options, FusedRun& run) {
  const Eigen::Vector3d earth = earth_in_fixture(*axes.attitude);
  const ClusterMeans means = cluster_means(axes.time_s, run.rate_deg_per_h, options.cluster_s);
  const Eigen::MatrixXd readings = cluster_means(axes.time_s, axes.rate_deg_per_h, options.cluster_s).mean;
  const AxisSet all = ~AxisSet{0} >> static_cast<unsigned>(64 - axes.axes());
  FusionSummary& summary = run.summary;
  summary.error = rate_error(means.mean, earth);
  const Eigen::MatrixXd differing = uncertainty_of_means(axes, options.averaging_s).varying_covariance();
  summary.of_all_axes = rate_error(fuse_set(axes, all, differing, readings), earth);
  summary.of_three = rate_error(fuse_set(axes, find_first_three(axes, differing), differing, readings), earth);
  const Eigen::VectorXd earth_on_axes = axes.directions * earth;
  for (Eigen::Index a = 0; a < axes.axes(); ++a) {
    const Eigen::ArrayXd deviation = readings.col(a).array() - earth_on_axes(a);
    const auto known = static_cast<double>(deviation.isFinite().count());
    summary.axes[static_cast<std::size_t>(a)].error_rms_deg_per_h =
        std::sqrt(deviation.isFinite().select(deviation.square(), 0).sum() / known);
  }
  summary.within_expanded = share_within(axes, options, means, run);
}

}  // namespace

void evaluate_at_rest(const FusedAxes& axes, const FusionOptions& options, FusedRun& run) {
  if (!axes.attitude) return;
  FusionSummary& summary = run.summary;
  summary.latitude_deg = axes.attitude->latitude_deg;
  summary.earth_deg_per_h = to_numbers(earth_in_fixture(*axes.attitude));
  summary.said_heading_deg = recorded_heading(*axes.attitude);
  evaluate_errors(axes, options, run);
  Stretch together{.name = "all holds", .rows = {}, .set = ~AxisSet{0}};
  for (const Stretch& stretch : find_stretches(axes, run)) {
    auto rest = evaluate_stretch(axes, stretch, options);
    if (!rest) continue;
    summary.holds.push_back(std::move(*rest));
    together.rows.insert(together.rows.end(), stretch.rows.begin(), stretch.rows.end());
    together.set &= stretch.set;
  }
  if (!together.rows.empty()) summary.rest = evaluate_stretch(axes, together, options);
  for (const RestStretch& rest : summary.holds) add_alarm(rest, summary.alarms);
  if (summary.rest) add_alarm(*summary.rest, summary.alarms);
  std::ranges::stable_sort(summary.alarms, {}, &Alarm::at_s);
}

}  // namespace gyrotherm::model
