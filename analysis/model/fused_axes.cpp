// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/fused_axes.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "analysis/data/clusters.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/stream.hpp"
#include "analysis/model/uncertainty.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::model {
namespace {

constexpr std::size_t kMostAxes = 64;
constexpr double kRadian = std::numbers::pi / 180;
constexpr double kUnknownRate = std::numeric_limits<double>::quiet_NaN();

tl::unexpected<Fault> axis_fault(const data::Dataset& dataset, std::string what) {
  return failure(FaultKind::usage, dataset.path + ", axis " + qualified_name(dataset.of), std::move(what));
}

Result<void> check_axis(const CompensatedAxis& axis) {
  const data::Dataset& dataset = axis.dataset;
  if (!dataset.direction)
    return axis_fault(dataset,
                      "the record contains no direction of the axis; add a direction to the axis in the rig file");
  if (dataset.has_own_reference)
    return axis_fault(
        dataset, "the record contains no Earth rate on the axis; add a [fixture] with its latitude to the rig file");
  if (data::sample_interval_s(dataset) != 1)
    return axis_fault(dataset, "the samples are not at intervals of one second");
  if (!axis.model.uncertainty) return axis_fault(dataset, "its model has no uncertainty budget; train the model again");
  if (const auto* other = find_other_axis(axis.model, dataset.of))
    return axis_fault(dataset, "its model belongs to another axis: it was trained on " + qualified_name(other->of));
  return {};
}

/// Returns the measured rate: the bias plus the Earth rate that was subtracted from it. NaN while the unit was turned
/// around, because its axes then have other directions.
Eigen::VectorXd measured_rate(const data::Dataset& dataset) {
  Eigen::VectorXd rate = dataset.bias_deg_per_h.array() + dataset.earth_rate_deg_per_h.value_or(0);
  for (Eigen::Index i = 0; i < rate.size(); ++i) {
    const int segment = dataset.segment(i);
    if (segment >= 0 && dataset.segments[static_cast<std::size_t>(segment)].unit.turned) rate(i) = kUnknownRate;
  }
  return rate;
}

/// Compensates axis `a` block by block, which avoids a second copy of a long record.
Result<void> compensate(FusedAxes& fused, Eigen::Index a, const CompensatedAxis& axis, Outside outside) {
  auto stream = CompensationStream::open(axis.model, axis.dataset.thermometers, outside);
  if (!stream) return failure(stream.error());
  constexpr Eigen::Index kBlock = 10000;
  const Eigen::VectorXd rate = measured_rate(axis.dataset);
  for (Eigen::Index from = 0; from < rate.size(); from += kBlock) {
    const Eigen::Index count = std::min(kBlock, rate.size() - from);
    const data::SampleMatrix temperatures = axis.dataset.temperature_c.middleRows(from, count);
    fused.rate_deg_per_h.col(a).segment(from, count) =
        stream->push_at(axis.dataset.time_s.segment(from, count), temperatures, rate.segment(from, count));
    fused.added_variance.col(a).segment(from, count) =
        form_variance(axis.model.uncertainty->budget.rows) * stream->excess().unaryExpr(&extrapolation_factor);
    for (const Eigen::Index row : stream->rows_outside())
      fused.outside[static_cast<std::size_t>(from + row)] |= AxisSet{1} << static_cast<unsigned>(a);
  }
  return {};
}

void add_thermometers(FusedAxes& fused, const std::vector<CompensatedAxis>& axes) {
  for (const CompensatedAxis& axis : axes) {
    const auto known_k = thermometers_in_use(axis.dataset).uncertainty_k;
    for (std::size_t i = 0; i < axis.dataset.thermometers.size(); ++i) {
      const std::string& name = axis.dataset.thermometers[i];
      if (data::is_own_value(name) || std::ranges::count(fused.thermometers, name) > 0) continue;
      fused.thermometers.push_back(name);
      fused.thermometer_in_a_year_k.push_back(known_k[i]);
      fused.temperature_c.conservativeResize(axis.dataset.time_s.size(), std::ssize(fused.thermometers));
      fused.temperature_c.rightCols(1) = axis.dataset.temperature_c.col(static_cast<Eigen::Index>(i));
    }
  }
}

/// Slopes of all axes with respect to all thermometers, °/h per K, at the clusters that all axes share.
struct Slopes {
  /// One matrix per thermometer: clusters × axes.
  std::vector<Eigen::MatrixXd> of;
};

Result<Slopes> compute_slopes(const FusedAxes& fused, const std::vector<CompensatedAxis>& axes) {
  std::vector<data::Clusters> clusters;
  // Number of axes that have a cluster with this start.
  std::map<double, std::size_t> axes_at;
  for (const CompensatedAxis& axis : axes) {
    auto made = data::make_clusters(axis.dataset, axis.model.cluster_length_s);
    if (!made) return failure(made.error());
    clusters.push_back(std::move(*made));
    for (const double start : clusters.back().start_s) ++axes_at[start];
  }
  const auto common = std::ranges::count(axes_at, axes.size(), &std::pair<const double, std::size_t>::second);
  Slopes slopes;
  slopes.of.assign(fused.thermometers.size(), Eigen::MatrixXd::Zero(common, std::ssize(axes)));
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const auto found = sensitivities(axes[a].model, clusters[a]);
    if (!found) return failure(found.error());
    std::vector<Eigen::Index> rows;
    for (Eigen::Index k = 0; k < clusters[a].start_s.size(); ++k)
      if (axes_at[clusters[a].start_s(k)] == axes.size()) rows.push_back(k);
    for (std::size_t t = 0; t < clusters[a].thermometers.size(); ++t) {
      const auto at = std::ranges::find(fused.thermometers, clusters[a].thermometers[t]) - fused.thermometers.begin();
      if (at == std::ssize(fused.thermometers)) continue;
      slopes.of[static_cast<std::size_t>(at)].col(static_cast<Eigen::Index>(a)) =
          (*found)(rows, static_cast<Eigen::Index>(t));
    }
  }
  return slopes;
}

/// Uncertainty of a thermometer in the first model that uses it, K.
struct ThermometerBudget {
  double drift_k{}, calibration_k{};
};

ThermometerBudget find_budget(const std::string& thermometer, const std::vector<CompensatedAxis>& axes) {
  for (const CompensatedAxis& axis : axes) {
    ThermometerBudget found;
    for (const BudgetRow& row : axis.model.uncertainty->budget.rows) {
      if (row.of != thermometer) continue;
      if (is_drift(row.source)) found.drift_k = drift_between_k(row, axis.dataset);
      if (row.source == Source::thermometer_calibration) found.calibration_k = row.standard_uncertainty;
    }
    if (found.drift_k > 0 || found.calibration_k > 0) return found;
  }
  return {};
}

void add_slopes(FusedAxes& fused, const std::vector<CompensatedAxis>& axes, const Slopes& slopes) {
  const Eigen::Index count = fused.axes();
  fused.sensitivity_deg_per_h_per_k = Eigen::MatrixXd::Zero(count, std::ssize(fused.thermometers));
  fused.thermometer_drift_covariance = Eigen::MatrixXd::Zero(count, count);
  fused.learnt = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t t = 0; t < fused.thermometers.size(); ++t) {
    const std::vector<Eigen::Index> rows = data::finite_rows(slopes.of[t]);
    if (rows.empty()) continue;
    const Eigen::MatrixXd known = slopes.of[t](rows, Eigen::all);
    fused.sensitivity_deg_per_h_per_k.col(static_cast<Eigen::Index>(t)) = known.colwise().mean().transpose();
    const Eigen::MatrixXd products = known.transpose() * known / static_cast<double>(rows.size());
    const ThermometerBudget budget = find_budget(fused.thermometers[t], axes);
    fused.thermometer_drift_covariance += std::pow(budget.drift_k, 2) * products;
    fused.learnt += std::pow(budget.calibration_k, 2) * products;
  }
}

/// Returns the row of a source; null if there is none.
const BudgetRow* find_row(const std::vector<BudgetRow>& rows, Source source) {
  const auto at = std::ranges::find(rows, source, &BudgetRow::source);
  return at == rows.end() ? nullptr : &*at;
}

Eigen::Vector3d axis_direction(const record::GyroUncertainty& known) {
  const double azimuth = *known.azimuth_deg * kRadian, elevation = *known.elevation_deg * kRadian;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), -std::sin(elevation)};
}

/// Returns the common tilt of axes without fixture angles, in degrees: √(Σ(c u)²/Σ c²) over the tilt rows of their
/// budgets. This tilt causes the same total variance of the Earth rates as the rows. It is computed from all axes,
/// because the slope of a single axis may be 0.
double common_tilt_deg(const std::vector<const BudgetRow*>& rows) {
  double rates = 0, slopes = 0;
  for (const BudgetRow* row : rows) {
    rates += std::pow(contribution_deg_per_h(*row), 2);
    slopes += std::pow(row->sensitivity, 2);
  }
  return slopes > 0 ? std::sqrt(rates / slopes) : 0;
}

/// Adds the recorded or assumed uncertainties of the fixture's angles to its attitude. An elevation rotates the fixture
/// about its horizontal axis, a roll about its x axis.
void add_angle_uncertainties(fusion::Attitude& attitude, const std::vector<CompensatedAxis>& axes) {
  std::vector<const BudgetRow*> tilts;
  std::vector<std::vector<BudgetRow>> all;
  for (const CompensatedAxis& axis : axes) all.push_back(budget_of_angles(axis.dataset));
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const auto widen = [&](double& maximum, Source source) {
      if (const BudgetRow* row = find_row(all[a], source)) maximum = std::max(maximum, row->standard_uncertainty);
    };
    widen(attitude.latitude_std_deg, Source::latitude);
    widen(attitude.azimuth_std_deg, Source::azimuth);
    if (const BudgetRow* row = find_row(all[a], Source::tilt)) tilts.push_back(row);
  }
  attitude.tilt_std_deg = common_tilt_deg(tilts);
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const BudgetRow *elevation = find_row(all[a], Source::fixture_elevation),
                    *roll = find_row(all[a], Source::fixture_roll);
    if (elevation == nullptr || roll == nullptr) continue;
    const Eigen::Vector3d x = attitude.to_local.col(0);
    const double azimuth = *axes[a].dataset.gyro_uncertainty.fixture_azimuth_deg * kRadian;
    const Eigen::Vector3d level(-std::sin(azimuth), std::cos(azimuth), 0);
    attitude.turn_covariance_deg2 = std::pow(elevation->standard_uncertainty, 2) * level * level.transpose() +
                                    std::pow(roll->standard_uncertainty, 2) * x * x.transpose();
    return;  // one fixture holds all axes
  }
}

/// Returns no attitude if the record does not state the orientation of its axes.
Result<std::optional<fusion::Attitude>> find_attitude(const FusedAxes& fused,
                                                      const std::vector<CompensatedAxis>& axes) {
  fusion::Attitude attitude;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const record::GyroUncertainty& known = axes[a].dataset.gyro_uncertainty;
    if (!known.latitude_deg || !known.azimuth_deg || !known.elevation_deg) return std::nullopt;
    sum += axis_direction(known) * fused.directions.row(static_cast<Eigen::Index>(a));
    attitude.latitude_deg = *known.latitude_deg;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handed = svd.matrixU().determinant() * svd.matrixV().determinant();
  attitude.to_local =
      svd.matrixU() * Eigen::Vector3d(1, 1, handed > 0 ? 1 : -1).asDiagonal() * svd.matrixV().transpose();
  constexpr double kGreatestDeviation = 1e-3;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const Eigen::Vector3d turned = attitude.to_local * fused.directions.row(static_cast<Eigen::Index>(a)).transpose();
    if ((turned - axis_direction(axes[a].dataset.gyro_uncertainty)).norm() > kGreatestDeviation)
      return axis_fault(axes[a].dataset, "its direction in the fixture contradicts its azimuth and elevation");
  }
  add_angle_uncertainties(attitude, axes);
  return std::optional(attitude);
}

/// Adds the uncertainties of the Earth rate and the scale factor in training. Latitude, azimuth, elevation and roll of
/// the fixture affect all axes together, each through a separate budget row; direction, tilt and scale factor affect a
/// single axis.
void add_training_uncertainty(FusedAxes& fused, const std::vector<CompensatedAxis>& axes) {
  for (const Source source : {Source::latitude, Source::azimuth, Source::fixture_elevation, Source::fixture_roll}) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(fused.axes());
    for (std::size_t a = 0; a < axes.size(); ++a)
      if (const BudgetRow* row = find_row(axes[a].model.uncertainty->budget.rows, source))
        column(static_cast<Eigen::Index>(a)) = row->sensitivity * row->standard_uncertainty;
    fused.learnt += column * column.transpose();
  }
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const auto at = static_cast<Eigen::Index>(a);
    for (const Source source : {Source::tilt, Source::axis_direction, Source::scale_factor})
      if (const BudgetRow* row = find_row(axes[a].model.uncertainty->budget.rows, source))
        fused.learnt(at, at) += std::pow(contribution_deg_per_h(*row), 2);
  }
}

}  // namespace

Result<FusedAxes> compensate_axes(const std::vector<CompensatedAxis>& axes, Outside outside) {
  if (axes.empty() || axes.size() > kMostAxes)
    return failure(FaultKind::usage, "fusion", fmt::format("{} axes, expected 3 to {}", axes.size(), kMostAxes));
  const data::Dataset& first = axes.front().dataset;
  FusedAxes fused{.simulated = first.simulated,
                  .run_id = first.run_id,
                  .profile_name = first.profile_name,
                  .segments = first.segments,
                  .time_s = first.time_s,
                  .segment = first.segment};
  const auto count = std::ssize(axes);
  fused.directions.resize(count, 3);
  fused.rate_deg_per_h.resize(first.time_s.size(), count);
  fused.outside.resize(static_cast<std::size_t>(first.time_s.size()));
  fused.added_variance.resize(first.time_s.size(), count);
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const CompensatedAxis& axis = axes[a];
    if (auto checked = check_axis(axis); !checked) return failure(checked.error());
    const auto at = static_cast<Eigen::Index>(a);
    fused.names.push_back(qualified_name(axis.dataset.of));
    fused.directions.row(at) =
        Eigen::RowVector3d((*axis.dataset.direction)[0], (*axis.dataset.direction)[1], (*axis.dataset.direction)[2]);
    fused.models.push_back(axis.model);
    for (const std::string& warning : origin_warnings(axis.model, find_origin(axis.dataset)))
      fused.warnings.push_back(fused.names.back() + ": " + warning);
    fused.step_deg_per_h.push_back(axis.dataset.step_deg_per_h);
    if (auto done = compensate(fused, at, axis, outside); !done) return failure(done.error());
  }
  add_thermometers(fused, axes);
  const auto slopes = compute_slopes(fused, axes);
  if (!slopes) return failure(slopes.error());
  add_slopes(fused, axes, *slopes);
  auto attitude = find_attitude(fused, axes);
  if (!attitude) return failure(attitude.error());
  fused.attitude = *attitude;
  add_training_uncertainty(fused, axes);
  return fused;
}

FusedUncertainty uncertainty_of_means(const FusedAxes& axes, double averaging_s) {
  FusedUncertainty result{
      .noise = Eigen::VectorXd::Zero(axes.axes()), .bias = axes.thermometer_drift_covariance, .learnt = axes.learnt};
  for (Eigen::Index a = 0; a < axes.axes(); ++a) {
    const Model& model = axes.models[static_cast<std::size_t>(a)];
    const Budget& budget = model.uncertainty->budget;
    const Budget over = convert_averaging(budget, averaging_s);
    // Predictions use trailing means over the cluster length. Thermometer noise therefore does not increase for shorter
    // averaging times.
    const Budget over_mean = convert_averaging(budget, std::max(averaging_s, model.cluster_length_s));
    for (std::size_t row = 0; row < over.rows.size(); ++row) {
      const Source source = over.rows[row].source;
      if (source == Source::counting) continue;  // added below, for this record
      const double variance = std::pow(contribution_deg_per_h(over.rows[row]), 2);
      if (source == Source::angle_random_walk) result.noise(a) += variance;
      if (source == Source::thermometer_noise)
        result.noise(a) += std::pow(contribution_deg_per_h(over_mean.rows[row]), 2);
      const bool is_noise = source == Source::angle_random_walk || source == Source::thermometer_noise;
      // Axes share the drift of thermometers. The drift of a unit's own values affects only the axis.
      const bool is_shared = source == Source::thermometer_drift && !data::is_own_value(over.rows[row].of);
      if (is_noise || is_shared || variability(source) == Variability::never) continue;
      result.bias(a, a) += variance;
    }
    // Each end of a count is uniformly off by up to half a step; the standard deviation of their sum is 1/√6 of a step.
    constexpr double kTwoEndsVarianceDivisor = 6;
    result.noise(a) +=
        std::pow(axes.step_deg_per_h[static_cast<std::size_t>(a)] / averaging_s, 2) / kTwoEndsVarianceDivisor;
  }
  return result;
}

Eigen::Matrix3d rate_covariance(const fusion::Gains& gains, const Eigen::MatrixXd& learnt,
                                const Eigen::VectorXd& added) {
  const Eigen::MatrixXd of_axes = learnt + Eigen::MatrixXd(added.asDiagonal());
  return gains.covariance + gains.rate * of_axes * gains.rate.transpose();
}

std::vector<Eigen::Index> members(AxisSet set) {
  std::vector<Eigen::Index> all;
  for (Eigen::Index a = 0; set != 0; ++a, set >>= 1)
    if ((set & 1) != 0) all.push_back(a);
  return all;
}

std::string names_in(const FusedAxes& axes, AxisSet set) {
  std::string names;
  for (const Eigen::Index a : members(set))
    names += (names.empty() ? "" : "+") + axes.names[static_cast<std::size_t>(a)];
  return names;
}

Result<fusion::Geometry> geometry_of_set(const FusedAxes& axes, AxisSet set, const Eigen::MatrixXd& covariance) {
  const std::vector<Eigen::Index> in = members(set);
  std::vector<fusion::InputAxis> checked;
  for (const Eigen::Index a : in)
    checked.push_back({.name = axes.names[static_cast<std::size_t>(a)],
                       .direction = axes.directions.row(a).transpose(),
                       .independent_deg_per_h = std::sqrt(covariance(a, a))});
  auto geometry = fusion::make_geometry(checked);
  if (geometry) geometry->covariance = covariance(in, in);
  return geometry;
}

Eigen::Vector3d earth_in_fixture(const fusion::Attitude& attitude) {
  return attitude.to_local.transpose() * fusion::earth_rate(attitude.latitude_deg);
}

}  // namespace gyrotherm::model
