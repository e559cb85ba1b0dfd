// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/power_on_constants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "analysis/data/distributions.hpp"
#include "analysis/data/input_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/model/inputs.hpp"
#include "analysis/model/qualification.hpp"
#include "analysis/model/uncertainty.hpp"

namespace gyrotherm::model {
namespace {

/// Numbers the power-on of each cluster without gaps, in order of appearance.
std::vector<Eigen::Index> number_power_ons(const data::Clusters& clusters) {
  std::map<int, Eigen::Index> number;
  std::vector<Eigen::Index> of_cluster;
  for (const int power_on : clusters.power_on)
    of_cluster.push_back(number.try_emplace(power_on, static_cast<Eigen::Index>(number.size())).first->second);
  return of_cluster;
}

/// Inputs of the plane with one indicator column per power-on, and the covariance of their errors.
struct Design {
  Eigen::MatrixXd z;
  Eigen::MatrixXd covariance;
  Eigen::Index power_ons{};
};

/// Scales a column of inputs and its row and column of the covariance. An input that does not vary keeps its unit.
void scale_input(Design& design, Eigen::Index input) {
  constexpr double kRounding = 1e-9;
  auto column = design.z.col(input);
  const double mean = column.mean();
  const double std = std::sqrt((column.array() - mean).square().mean());
  const double scale = std > kRounding * std::abs(mean) ? std : 1;
  column = (column.array() - mean) / scale;
  design.covariance.row(input) /= scale;
  design.covariance.col(input) /= scale;
}

Result<Design> make_design(const data::Clusters& clusters, const std::vector<Eigen::Index>& rows,
                           const data::SampleMatrix& inputs, const std::vector<Eigen::Index>& numbers,
                           const PowerOnRule& rule) {
  const auto covariance = input_covariance(rule.terms, pick_clusters(clusters, rows), rule.thermometer_uncertainty_k);
  if (!covariance) return failure(covariance.error());
  Design design{.z = {}, .covariance = {}, .power_ons = *std::ranges::max_element(numbers) + 1};
  const Eigen::Index all = inputs.cols() + design.power_ons;
  design.z.setZero(std::ssize(rows), all);
  design.z.leftCols(inputs.cols()) = inputs(rows, Eigen::all);
  design.covariance.setZero(all, all);
  design.covariance.topLeftCorner(inputs.cols(), inputs.cols()) = *covariance;
  for (Eigen::Index input = 0; input < inputs.cols(); ++input) scale_input(design, input);
  for (Eigen::Index k = 0; k < std::ssize(rows); ++k)
    design.z(k, inputs.cols() + numbers[static_cast<std::size_t>(rows[static_cast<std::size_t>(k)])]) = 1;
  return design;
}

/// Returns the variance of a single independent residual, enlarged for the correlation of neighbouring ones.
double residual_variance(const Eigen::VectorXd& residual, double parameters, const data::Clusters& clusters,
                         const std::vector<Eigen::Index>& rows) {
  const auto count = static_cast<double>(residual.size());
  const double effective = std::max(1.0, compute_figures(residual, clusters, rows).effective.of_mean);
  return residual.squaredNorm() / std::max(1.0, count - parameters) * count / effective;
}

/// Estimates the constants and the variance of the residuals in turn, until both fit together.
Eigen::VectorXd solve_constants(Design design, const Eigen::VectorXd& y, const data::Clusters& clusters,
                                const std::vector<Eigen::Index>& rows, double repeatability) {
  constexpr int kRounds = 5;
  const auto count = static_cast<double>(y.size());
  double variance = (y.array() - y.mean()).square().mean();
  Eigen::VectorXd constants;
  for (int round = 0; round < kRounds; ++round) {
    // The penalty of the plane is n times the covariance.
    design.covariance.diagonal().tail(design.power_ons).setConstant(variance / (repeatability * repeatability * count));
    const methods::PenalisedPlane plane = methods::penalised_plane(design.z, y, design.covariance);
    const Eigen::VectorXd residual = y - ((design.z * plane.weights).array() + plane.b).matrix();
    variance = residual_variance(residual, plane.effective_parameters, clusters, rows);
    constants = plane.weights.tail(design.power_ons);
  }
  return constants;
}

}  // namespace

PowerOnRule power_on_rule(const data::Dataset& dataset) {
  PowerOnRule rule{.terms = {},
                   .thermometer_uncertainty_k = thermometers_in_use(dataset).uncertainty_k,
                   .repeatability_deg_per_h = turn_on_repeatability(dataset)};
  if (auto plan = plan_inputs(std::string(kRecommendedInputs), dataset)) rule.terms = std::move(plan->fixed);
  return rule;
}

Result<Eigen::VectorXd> power_on_constants(const data::Clusters& clusters, const PowerOnRule& rule) {
  Eigen::VectorXd constants = Eigen::VectorXd::Zero(clusters.start_s.size());
  if (count_power_ons(clusters) < 2 || rule.terms.empty() || !(rule.repeatability_deg_per_h > 0)) return constants;
  const auto inputs = evaluate(rule.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const std::vector<Eigen::Index> rows = data::finite_rows(*inputs);
  if (rows.size() < 2) return constants;
  const std::vector<Eigen::Index> numbers = number_power_ons(clusters);
  auto design = make_design(clusters, rows, *inputs, numbers, rule);
  if (!design) return failure(design.error());
  const Eigen::VectorXd y = clusters.bias_deg_per_h(rows);
  const Eigen::VectorXd of_power_on =
      solve_constants(std::move(*design), y, clusters, rows, rule.repeatability_deg_per_h);
  for (Eigen::Index k = 0; k < constants.size(); ++k) constants(k) = of_power_on(numbers[static_cast<std::size_t>(k)]);
  return constants;
}

Result<data::Clusters> without_power_on_constants(data::Clusters clusters, const PowerOnRule& rule) {
  const auto constants = power_on_constants(clusters, rule);
  if (!constants) return failure(constants.error());
  clusters.bias_deg_per_h -= *constants;
  return clusters;
}

std::vector<PowerOn> list_power_ons(const data::Clusters& clusters, const Eigen::VectorXd& constants) {
  std::vector<PowerOn> all;
  if (count_power_ons(clusters) < 2) return all;
  const std::vector<Eigen::Index> numbers = number_power_ons(clusters);
  all.resize(static_cast<std::size_t>(count_power_ons(clusters)));
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    PowerOn& power_on = all[static_cast<std::size_t>(numbers[k])];
    ++power_on.clusters;
    power_on.constant_deg_per_h = constants(static_cast<Eigen::Index>(k));
  }
  return all;
}

std::string describe_scatter(const std::vector<PowerOn>& power_ons, double repeatability_deg_per_h) {
  constexpr double kRare = 0.01;
  if (power_ons.size() < 2 || !(repeatability_deg_per_h > 0)) return {};
  double squares = 0;
  for (const PowerOn& power_on : power_ons) squares += std::pow(power_on.constant_deg_per_h, 2);
  const auto freedom = static_cast<double>(power_ons.size() - 1);
  if (squares / std::pow(repeatability_deg_per_h, 2) <= data::chi_squared_limit(kRare, freedom)) return {};
  return fmt::format(
      "the constants of {} power-ons have a standard deviation of {:.2g} °/h, more than the turn-on repeatability of "
      "{:.2g} °/h permits",
      power_ons.size(), std::sqrt(squares / freedom), repeatability_deg_per_h);
}

}  // namespace gyrotherm::model
