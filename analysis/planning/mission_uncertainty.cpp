// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/mission_uncertainty.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "analysis/model/budget.hpp"
#include "analysis/model/uncertainty.hpp"

namespace gyrotherm::planning {
namespace {

/// Share of the variance of the model form that further clusters lower.
constexpr double kLearnableShare = 0.5;

/// Returns the predictive variance of each row, (°/h)²; 0 for a model without one.
Result<Eigen::VectorXd> open_variance(const model::Model& model, const data::SampleMatrix& inputs) {
  if (!model.variance) return Eigen::VectorXd::Zero(inputs.rows()).eval();
  return predict_with_std(model, inputs).map([](const model::Prediction& predicted) -> Eigen::VectorXd {
    return predicted.std_deg_per_h.cwiseAbs2();
  });
}

/// Returns the covariance Σ of a plane's coefficients after observations of its features Φ with the given variance:
/// R(I + RᵀΦᵀΦR/s²)⁻¹Rᵀ with Σ = RRᵀ, which has the size of the coefficients and never needs the inverse of Σ.
Eigen::MatrixXd update_covariance(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& features, double variance) {
  if (features.rows() == 0) return covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const Eigen::MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd seen = features * root;
  Eigen::MatrixXd information = seen.transpose() * seen / variance;
  information.diagonal().array() += 1;
  return root * information.llt().solve(root.transpose());
}

}  // namespace

Result<double> mission_uncertainty(const model::Model& model, const data::Clusters& mission) {
  assert(model.uncertainty);
  const auto inputs = evaluate(model.terms, mission);
  if (!inputs) return failure(inputs.error());
  const auto open = open_variance(model, *inputs);
  if (!open) return failure(open.error());
  const model::Uncertainty& trained = *model.uncertainty;
  const std::vector<model::BudgetRow>& rows = trained.budget.rows;
  const bool is_a_row = std::ranges::find(rows, model::Source::coefficients, &model::BudgetRow::source) != rows.end();
  double common = 0;
  for (const model::BudgetRow& row : rows)
    if (row.source != model::Source::coefficients) common += std::pow(contribution_deg_per_h(row), 2);
  const Eigen::VectorXd excess = apply_range_policy(model, *inputs, model::Outside::extrapolate).excess;
  Eigen::VectorXd variance = form_variance(rows) * excess.unaryExpr(&model::extrapolation_factor);
  variance.array() += common;
  if (is_a_row)
    variance += *open;
  else if (std::isfinite(trained.variance_in_training))
    variance.array() += (open->array() - trained.variance_in_training).max(0);
  const std::vector<Eigen::Index> known = data::finite_rows(*inputs);
  if (known.empty())
    return failure(FaultKind::usage, "mission", "no cluster of the mission has a value of every input of the model");
  // A mission outside a trained range without width has an infinite variance, which must not be left out.
  const double mean = variance(known).mean();
  return combined(rows).coverage_factor * std::sqrt(std::isnan(mean) ? std::numeric_limits<double>::infinity() : mean);
}

Result<double> mean_variance(const model::Model& model, const data::Clusters& clusters) {
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const std::vector<Eigen::Index> rows = data::finite_rows(*inputs);
  if (rows.empty()) return 0.0;
  return open_variance(model, (*inputs)(rows, Eigen::all)).map([](const Eigen::VectorXd& open) { return open.mean(); });
}

void scale_form(model::Model& model, double variance_ratio) {
  for (model::BudgetRow& row : model.uncertainty->budget.rows)
    if (row.source == model::Source::model_form)
      row.standard_uncertainty *= std::sqrt(1 - kLearnableShare + kLearnableShare * variance_ratio);
}

Result<void> add_clusters(model::Model& model, const data::Clusters& clusters) {
  assert(model.variance && std::holds_alternative<methods::LinearModel>(model.function));
  const auto inputs = evaluate(model.terms, clusters);
  if (!inputs) return failure(inputs.error());
  const std::vector<Eigen::Index> rows = data::finite_rows(*inputs);
  if (rows.empty()) return {};
  const data::SampleMatrix known = (*inputs)(rows, Eigen::all);
  model.input_min = model.input_min.cwiseMin(known.colwise().minCoeff());
  model.input_max = model.input_max.cwiseMax(known.colwise().maxCoeff());
  const double variance = std::pow(model.variance->noise, 2) * correlation_factor(model);
  model.variance->posterior = update_covariance(
      model.variance->posterior, compute_features(*model.variance, apply(model.scaling, known)), variance);
  return {};
}

Result<model::Model> expected_after(const model::Model& model, const data::Clusters& mission,
                                    const data::Clusters& further, int further_power_ons) {
  assert(model.uncertainty);
  model::Model after = model;
  if (const auto added = add_clusters(after, further); !added) return failure(added.error());
  const auto before = mean_variance(model, mission), open = mean_variance(after, mission);
  if (!before || !open) return failure(before ? open.error() : before.error());
  const double ratio = *before > 0 ? std::clamp(*open / *before, 0.0, 1.0) : 1;
  scale_form(after, ratio);
  for (model::BudgetRow& row : after.uncertainty->budget.rows) {
    if (row.source != model::Source::turn_on) continue;
    const double starts = 1 / (row.sensitivity * row.sensitivity - 1);
    row.sensitivity = std::sqrt(1 + 1 / (starts + further_power_ons));
  }
  after.uncertainty->variance_in_training *= ratio;
  return after;
}

}  // namespace gyrotherm::planning
