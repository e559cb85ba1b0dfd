// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/thermal_response.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/quantity.hpp"

namespace gyrotherm::planning {
namespace {

constexpr std::array kResponseTimesS = {150.0, 600.0, 1800.0, 3600.0, 10800.0};
/// Shares of the set point in the typical response.
constexpr std::array kTypicalGain = {0.1, 0.1, 0.4, 0.4, 0.0};
/// Typical temperature of a unit above the air, K.
constexpr double kTypicalHeating_k = 5;

/// Bodies that follow an input with each time constant: rows of the path × time constants.
Eigen::MatrixXd first_order_responses(const Eigen::VectorXd& input, double start, double length_s,
                                      const Eigen::VectorXd& times_s) {
  Eigen::MatrixXd followed(input.size(), times_s.size());
  Eigen::RowVectorXd state = Eigen::RowVectorXd::Constant(times_s.size(), start);
  const Eigen::RowVectorXd step = 1 - (-length_s * times_s.transpose().array().inverse()).exp();
  for (Eigen::Index k = 0; k < input.size(); ++k) {
    const Eigen::RowVectorXd before = state;
    state.array() += step.array() * (input(k) - state.array());
    followed.row(k) = 0.5 * (before + state);  // approximates the mean
  }
  return followed;
}

Eigen::VectorXd power_of(const ProgramPath& path) {
  return path.start.unaryExpr([](int start) { return start < 0 ? 0.0 : 1.0; });
}

/// Returns the regressors of the response along a path: F_j, P_j and 1.
Eigen::MatrixXd regressors(const ProgramPath& path, const Eigen::VectorXd& times_s) {
  const Eigen::Index count = times_s.size();
  Eigen::MatrixXd all(path.set_point_c.size(), 2 * count + 1);
  if (all.rows() == 0) return all;
  all.leftCols(count) = first_order_responses(path.set_point_c, path.set_point_c(0), path.length_s, times_s);
  all.middleCols(count, count) = first_order_responses(power_of(path), 1, path.length_s, times_s);
  all.rightCols(1).setOnes();
  return all;
}

/// Knowledge of a response before a record: precision of its coefficients, and precision times their mean.
struct PriorKnowledge {
  Eigen::MatrixXd precision;
  Eigen::VectorXd weighted_mean;
};

PriorKnowledge make_prior_knowledge(Eigen::Index times) {
  constexpr double kGainStd = 0.5, kHeatingStd_k = 10, kOffsetStd_c = 1, kSumStd = 0.02;
  PriorKnowledge prior{.precision = Eigen::MatrixXd::Zero(2 * times + 1, 2 * times + 1),
                       .weighted_mean = Eigen::VectorXd::Zero(2 * times + 1)};
  prior.precision.diagonal().head(times).setConstant(1 / (kGainStd * kGainStd));
  prior.precision.diagonal().segment(times, times).setConstant(1 / (kHeatingStd_k * kHeatingStd_k));
  prior.precision(2 * times, 2 * times) = 1 / (kOffsetStd_c * kOffsetStd_c);
  for (Eigen::Index j = 0; j < times; ++j) {
    prior.weighted_mean(j) = kTypicalGain[static_cast<std::size_t>(j)] / (kGainStd * kGainStd);
    prior.weighted_mean(times + j) = kTypicalHeating_k / static_cast<double>(times) / (kHeatingStd_k * kHeatingStd_k);
  }
  // In equilibrium a unit is as warm as the air plus its own heating.
  prior.precision.topLeftCorner(times, times).array() += 1 / (kSumStd * kSumStd);
  prior.weighted_mean.head(times).array() += 1 / (kSumStd * kSumStd);
  return prior;
}

Eigen::VectorXd response_times() {
  return Eigen::Map<const Eigen::VectorXd>(kResponseTimesS.data(), std::ssize(kResponseTimesS));
}

/// Averages the readings of a thermometer over each cluster of a run; NaN without a reading.
Eigen::VectorXd cluster_means(const data::Dataset& dataset, Eigen::Index column, double length_s, Eigen::Index rows) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(rows);
  Eigen::VectorXi count = Eigen::VectorXi::Zero(rows);
  for (Eigen::Index i = 0; i < dataset.time_s.size(); ++i) {
    const double value = dataset.temperature_c(i, column);
    if (!std::isfinite(value)) continue;
    const auto k = static_cast<Eigen::Index>(std::floor((dataset.time_s(i) - dataset.time_s(0)) / length_s));
    sum(k) += value;
    ++count(k);
  }
  for (Eigen::Index k = 0; k < rows; ++k)
    sum(k) = count(k) > 0 ? sum(k) / count(k) : std::numeric_limits<double>::quiet_NaN();
  return sum;
}

}  // namespace

ThermalResponse typical_response(const std::vector<std::string>& thermometers) {
  const auto columns = std::ssize(thermometers);
  ThermalResponse response{.thermometers = thermometers,
                           .time_constants_s = response_times(),
                           .gain = {},
                           .heating_k = {},
                           .offset_c = Eigen::RowVectorXd::Zero(columns),
                           .rms_k = std::numeric_limits<double>::quiet_NaN()};
  const Eigen::Map<const Eigen::VectorXd> gain(kTypicalGain.data(), std::ssize(kTypicalGain));
  response.gain = gain.replicate(1, columns);
  response.heating_k.setConstant(gain.size(), columns, kTypicalHeating_k / static_cast<double>(gain.size()));
  return response;
}

Result<ThermalResponse> fit_response(const data::Dataset& dataset, double length_s) {
  // Errors of the response are correlated over many clusters, so each cluster counts as a reading within 0.5 K.
  constexpr double kReadingStd_k = 0.5;
  if (dataset.gradients.empty())
    return failure(FaultKind::usage, dataset.path, "has no gradient thermometer, so no temperature can be predicted");
  const ProgramPath path = recorded_path(dataset, length_s);
  if (path.set_point_c.size() == 0 || !path.set_point_c.allFinite())
    return failure(FaultKind::usage, dataset.path, "has no set points, so no temperature can be predicted");
  ThermalResponse response = typical_response(dataset.gradients);
  const Eigen::Index times = response.time_constants_s.size();
  const Eigen::MatrixXd all = regressors(path, response.time_constants_s);
  const PriorKnowledge prior = make_prior_knowledge(times);
  double squares = 0;
  Eigen::Index readings = 0;
  for (std::size_t q = 0; q < dataset.gradients.size(); ++q) {
    const auto found = std::ranges::find(dataset.thermometers, dataset.gradients[q]) - dataset.thermometers.begin();
    const Eigen::VectorXd means = cluster_means(dataset, found, length_s, all.rows());
    std::vector<Eigen::Index> rows;
    for (Eigen::Index k = 0; k < means.size(); ++k)
      if (std::isfinite(means(k))) rows.push_back(k);
    const Eigen::MatrixXd known = all(rows, Eigen::all);
    const Eigen::VectorXd target = means(rows);
    const double weight = 1 / (kReadingStd_k * kReadingStd_k);
    const Eigen::VectorXd fitted = (prior.precision + weight * known.transpose() * known)
                                       .ldlt()
                                       .solve(prior.weighted_mean + weight * known.transpose() * target);
    const auto column = static_cast<Eigen::Index>(q);
    response.gain.col(column) = fitted.head(times);
    response.heating_k.col(column) = fitted.segment(times, times);
    response.offset_c(column) = fitted(2 * times);
    squares += (target - known * fitted).squaredNorm();
    readings += target.size();
  }
  response.rms_k = std::sqrt(squares / static_cast<double>(std::max<Eigen::Index>(readings, 1)));
  return response;
}

Eigen::MatrixXd predict_temperatures(const ThermalResponse& response, const ProgramPath& path) {
  const Eigen::Index times = response.time_constants_s.size();
  Eigen::MatrixXd coefficients(2 * times + 1, response.gain.cols());
  coefficients << response.gain, response.heating_k, response.offset_c;
  return regressors(path, response.time_constants_s) * coefficients;
}

data::Clusters predict_clusters(const ThermalResponse& response, const ProgramPath& path, Eigen::Index first) {
  data::Clusters clusters;
  clusters.length_s = path.length_s;
  clusters.thermometers = response.thermometers;
  clusters.history.temperature_c = predict_temperatures(response, path);
  const Eigen::Index all = path.set_point_c.size();
  clusters.history.elapsed_s.setConstant(all, path.length_s);
  if (all > 0) clusters.history.elapsed_s(0) = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = first; k < all; ++k)
    if (path.start(k) >= 0) clusters.moments.push_back(k);
  const std::vector<Eigen::Index>& rows = clusters.moments;
  const auto count = std::ssize(rows);
  clusters.start_s.resize(count);
  for (Eigen::Index k = 0; k < count; ++k)
    clusters.start_s(k) = static_cast<double>(rows[static_cast<std::size_t>(k)]) * path.length_s;
  clusters.temperature_c = clusters.history.temperature_c(rows, Eigen::all);
  clusters.rate_c_per_min.setConstant(count, clusters.temperature_c.cols(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index row = rows[static_cast<std::size_t>(k)];
    if (row == 0) continue;
    clusters.rate_c_per_min.row(k) =
        (clusters.history.temperature_c.row(row) - clusters.history.temperature_c.row(row - 1)) *
        (kSecondsPerMinute / path.length_s);
  }
  clusters.bias_deg_per_h.setZero(count);
  clusters.true_bias_deg_per_h.setConstant(count, std::numeric_limits<double>::quiet_NaN());
  clusters.set_point_c = path.set_point_c(rows);
  clusters.power_on = path.start(rows);
  for (Eigen::VectorXi* numbers : {&clusters.segment, &clusters.last_segment, &clusters.cycle})
    numbers->setConstant(count, -1);
  clusters.samples.setConstant(count, static_cast<int>(std::lround(path.length_s)));
  return clusters;
}

}  // namespace gyrotherm::planning
