// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/population.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

namespace gyrotherm::population {
namespace {

/// Returns R with RRᵀ = S. Eigenvalues that are negative because of rounding are treated as 0.
Eigen::MatrixXd root_of_covariance(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

/// Posterior of a unit: a prior with this root combined with the unit's precision.
struct JoinedPrior {
  Eigen::MatrixXd covariance;  ///< V
  double log_determinant{};    ///< log det(I + RᵀAR)
};

JoinedPrior join(const Eigen::MatrixXd& root, const Eigen::MatrixXd& precision) {
  Eigen::MatrixXd inside = root.transpose() * precision * root;
  inside.diagonal().array() += 1;
  const Eigen::LLT<Eigen::MatrixXd> factor(inside);
  const Eigen::MatrixXd half = factor.matrixL().solve(root.transpose());
  return {half.transpose() * half, 2 * factor.matrixLLT().diagonal().array().log().sum()};
}

/// Returns −2 log p of a unit's values for coefficients N(mean, RRᵀ), given their posterior.
double deviance(const UnitInformation& unit, const Eigen::VectorXd& mean, const JoinedPrior& with) {
  const Eigen::VectorXd unexplained = unit.projection - unit.precision * mean;
  const double square = unit.square - 2 * mean.dot(unit.projection) + mean.dot(unit.precision * mean) -
                        unexplained.dot(with.covariance * unexplained);
  return unit.rows * std::log(2 * std::numbers::pi) + unit.log_determinant + with.log_determinant + square;
}

/// Intermediate results for one Σ.
struct Step {
  std::vector<JoinedPrior> units;
  Eigen::VectorXd mean;
  Eigen::MatrixXd mean_covariance;
  double log_likelihood{};
};

Result<Step> compute_step(std::span<const UnitInformation> units, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd root = root_of_covariance(covariance);
  const Eigen::Index count = covariance.rows();
  Step step;
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd projection = Eigen::VectorXd::Zero(count);
  for (const UnitInformation& unit : units) {
    step.units.push_back(join(root, unit.precision));
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::Identity(count, count) - unit.precision * step.units.back().covariance;  // (I + AΣ)⁻¹
    precision += left * unit.precision;
    projection += left * unit.projection;
  }
  precision = 0.5 * (precision + precision.transpose()).eval();
  const Eigen::LLT<Eigen::MatrixXd> factor(precision);
  if (factor.info() != Eigen::Success || !precision.allFinite())
    return failure(FaultKind::numeric, "type prior", "the data of all units do not determine the coefficients");
  step.mean = factor.solve(projection);
  step.mean_covariance = factor.solve(Eigen::MatrixXd::Identity(count, count));
  double twice = 2 * factor.matrixLLT().diagonal().array().log().sum() -
                 static_cast<double>(count) * std::log(2 * std::numbers::pi);
  for (std::size_t u = 0; u < units.size(); ++u) twice += deviance(units[u], step.mean, step.units[u]);
  step.log_likelihood = -0.5 * twice;
  return step;
}

/// Returns Σ_u E[(w_u − μ)(w_u − μ)ᵀ] given all values.
Eigen::MatrixXd expected_squares(std::span<const UnitInformation> units, const Step& step) {
  const Eigen::Index count = step.mean.size();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t u = 0; u < units.size(); ++u) {
    const Eigen::MatrixXd& v = step.units[u].covariance;
    const Eigen::VectorXd apart = v * (units[u].projection - units[u].precision * step.mean);
    const Eigen::MatrixXd drawn = v * units[u].precision;
    sum += apart * apart.transpose() + v + drawn * step.mean_covariance * drawn.transpose();
  }
  return 0.5 * (sum + sum.transpose());
}

/// Returns log p of Σ under the prior of a shrinkage, up to a constant; 0 without a shrinkage.
double log_prior(const Eigen::MatrixXd& covariance, const std::optional<Shrinkage>& shrinkage) {
  if (!shrinkage) return 0;
  const Eigen::LDLT<Eigen::MatrixXd> factor(covariance);
  const Eigen::MatrixXd target = shrinkage->variances.asDiagonal();
  return -0.5 * shrinkage->worth_units * (factor.vectorD().array().log().sum() + factor.solve(target).trace());
}

Population make_population(const Step& step, const Eigen::MatrixXd& covariance) {
  return {step.mean, covariance, step.mean_covariance};
}

}  // namespace

UnitInformation unit_information(const Eigen::MatrixXd& z, const Eigen::VectorXd& y, double log_determinant) {
  assert(z.rows() == y.size());
  return {z.transpose() * z, z.transpose() * y, y.squaredNorm(), log_determinant, static_cast<double>(y.size())};
}

UnitInformation no_information(Eigen::Index coefficients) {
  return {Eigen::MatrixXd::Zero(coefficients, coefficients), Eigen::VectorXd::Zero(coefficients)};
}

UnitInformation operator+(const UnitInformation& a, const UnitInformation& b) {
  return {a.precision + b.precision, a.projection + b.projection, a.square + b.square,
          a.log_determinant + b.log_determinant, a.rows + b.rows};
}

Coefficients posterior(const Coefficients& prior, const UnitInformation& own) {
  const JoinedPrior with = join(root_of_covariance(prior.covariance), own.precision);
  return {prior.mean + with.covariance * (own.projection - own.precision * prior.mean), with.covariance};
}

double log_predictive(const Coefficients& prior, const UnitInformation& unit) {
  return -0.5 * deviance(unit, prior.mean, join(root_of_covariance(prior.covariance), unit.precision));
}

Coefficients next_unit(const Population& population) {
  return {population.mean, population.covariance + population.mean_covariance};
}

Result<PopulationFit> fit_population_mean(std::span<const UnitInformation> units, const Eigen::MatrixXd& covariance) {
  const auto step = compute_step(units, covariance);
  if (!step) return failure(step.error());
  return PopulationFit{.population = make_population(*step, covariance), .log_likelihood = step->log_likelihood};
}

Result<PopulationFit> fit_population(std::span<const UnitInformation> units, const Eigen::MatrixXd& start,
                                     const PopulationOptions& options) {
  constexpr std::size_t kFewestUnits = 3;
  if (units.size() < kFewestUnits) {
    return failure(
        FaultKind::usage, "type prior",
        fmt::format("{} units are too few for the spread between units: give at least {}", units.size(), kFewestUnits));
  }
  PopulationFit fit;
  Eigen::MatrixXd covariance = start;
  auto step = compute_step(units, covariance);
  if (!step) return failure(step.error());
  const auto count = static_cast<double>(units.size());
  double before = step->log_likelihood + log_prior(covariance, options.shrinkage);
  while (fit.iterations < options.most_iterations && !fit.converged) {
    covariance = expected_squares(units, *step);
    if (options.shrinkage) {
      const double worth = options.shrinkage->worth_units;
      covariance.diagonal() += worth * options.shrinkage->variances;
      covariance /= count + worth;
    } else {
      covariance /= count;
    }
    if (options.independent) covariance = covariance.diagonal().asDiagonal().toDenseMatrix();
    step = compute_step(units, covariance);
    if (!step) return failure(step.error());
    ++fit.iterations;
    const double now = step->log_likelihood + log_prior(covariance, options.shrinkage);
    fit.converged = now - before < options.tolerance;
    before = now;
  }
  fit.population = make_population(*step, covariance);
  fit.log_likelihood = before;
  return fit;
}

}  // namespace gyrotherm::population
