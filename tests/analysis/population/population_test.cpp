// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/population.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::population {
namespace {

using data::normal_matrix;
using data::normal_vector;

/// Returns a random positive definite matrix.
Eigen::MatrixXd random_covariance(Eigen::Index size, std::uint64_t seed) {
  const Eigen::MatrixXd root = normal_matrix(size, size, seed);
  return root * root.transpose() + 0.2 * Eigen::MatrixXd::Identity(size, size);
}

struct DenseUnit {
  Eigen::MatrixXd z;
  Eigen::VectorXd y;
};

DenseUnit draw_unit(const Coefficients& population, Eigen::Index rows, double noise, std::uint64_t seed) {
  const Eigen::Index count = population.mean.size();
  DenseUnit unit{normal_matrix(rows, count, seed), {}};
  unit.z.col(0).setOnes();
  const Eigen::MatrixXd root = population.covariance.llt().matrixL();
  const Eigen::VectorXd own = population.mean + root * normal_vector(count, seed + 10000);
  unit.y = unit.z * own + noise * normal_vector(rows, seed + 20000);
  return unit;
}

/// Returns the sufficient statistics of a unit whose values have the standard deviation `noise`.
UnitInformation information(const DenseUnit& unit, double noise) {
  return unit_information(unit.z / noise, unit.y / noise, 2 * static_cast<double>(unit.y.size()) * std::log(noise));
}

double log_normal_density(const Eigen::VectorXd& y, const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd deviation = y - mean;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  return -0.5 * deviation.dot(factor.solve(deviation)) - factor.matrixLLT().diagonal().array().log().sum() -
         0.5 * static_cast<double>(y.size()) * std::log(2 * std::numbers::pi);
}

/// The prior is 10 ± 2, with a precision of ¼. Four values of 13 with noise 1 have a precision of 4.
TEST(Population, HasPosteriorOfManualComputation) {
  const Coefficients prior{Eigen::VectorXd::Constant(1, 10), Eigen::MatrixXd::Constant(1, 1, 4)};
  const auto own = unit_information(Eigen::MatrixXd::Ones(4, 1), Eigen::VectorXd::Constant(4, 13));
  const Coefficients after = posterior(prior, own);
  EXPECT_NEAR(after.mean(0), (10 * 0.25 + 13 * 4) / 4.25, 1e-12);
  EXPECT_NEAR(after.covariance(0, 0), 1 / 4.25, 1e-12);
}

TEST(Population, HasPosteriorAndPredictiveOfDenseComputation) {
  const double noise = 0.7;
  const Coefficients prior{normal_vector(3, 1), random_covariance(3, 2)};
  const DenseUnit unit = draw_unit(prior, 8, noise, 3);
  const auto own = information(unit, noise);
  const Eigen::MatrixXd precision = unit.z.transpose() * unit.z / (noise * noise) + prior.covariance.inverse();
  const Eigen::VectorXd mean =
      precision.ldlt().solve(unit.z.transpose() * unit.y / (noise * noise) + prior.covariance.inverse() * prior.mean);
  const Coefficients after = posterior(prior, own);
  EXPECT_LT((after.mean - mean).norm(), 1e-10);
  EXPECT_LT((after.covariance - precision.inverse()).norm(), 1e-10);
  const Eigen::MatrixXd covariance =
      unit.z * prior.covariance * unit.z.transpose() + noise * noise * Eigen::MatrixXd::Identity(8, 8);
  EXPECT_NEAR(log_predictive(prior, own), log_normal_density(unit.y, unit.z * prior.mean, covariance), 1e-9);
}

TEST(Population, KeepsPriorWithoutInformation) {
  Coefficients prior{normal_vector(3, 1), random_covariance(3, 2)};
  const Coefficients after = posterior(prior, no_information(3));
  EXPECT_LT((after.mean - prior.mean).norm(), 1e-14);
  EXPECT_LT((after.covariance - prior.covariance).norm(), 1e-12);
  EXPECT_EQ(log_predictive(prior, no_information(3)), 0);
}

TEST(Population, TreatsCoefficientWithoutVarianceAsKnown) {
  Coefficients prior{Eigen::Vector2d(1, 2), Eigen::Vector2d(4, 0).asDiagonal()};
  const auto own = unit_information(normal_matrix(20, 2, 1), normal_vector(20, 2));
  const Coefficients after = posterior(prior, own);
  EXPECT_EQ(after.mean(1), 2);
  EXPECT_EQ(after.covariance(1, 1), 0);
  EXPECT_LT(after.covariance(0, 0), 1);
}

std::vector<UnitInformation> draw_units(const Coefficients& population, int units, Eigen::Index rows, double noise,
                                        std::uint64_t seed) {
  std::vector<UnitInformation> all;
  for (int u = 0; u < units; ++u)
    all.push_back(information(draw_unit(population, rows, noise, 100 * seed + static_cast<std::uint64_t>(u)), noise));
  return all;
}

/// The expected likelihood is the normal density of all values of all units, with μ integrated out.
TEST(Population, HasRestrictedLikelihoodOfDenseComputation) {
  const double noise = 0.5;
  const Coefficients population{normal_vector(2, 1), random_covariance(2, 2)};
  std::vector<DenseUnit> dense;
  std::vector<UnitInformation> units;
  for (std::uint64_t u = 0; u < 4; ++u) {
    dense.push_back(draw_unit(population, 5, noise, u + 5));
    units.push_back(information(dense.back(), noise));
  }
  const Eigen::MatrixXd covariance = random_covariance(2, 9);
  Eigen::MatrixXd all = noise * noise * Eigen::MatrixXd::Identity(20, 20), z(20, 2);
  Eigen::VectorXd y(20);
  for (Eigen::Index u = 0; u < 4; ++u) {
    const DenseUnit& unit = dense[static_cast<std::size_t>(u)];
    all.block(5 * u, 5 * u, 5, 5) += unit.z * covariance * unit.z.transpose();
    z.middleRows(5 * u, 5) = unit.z;
    y.segment(5 * u, 5) = unit.y;
  }
  const Eigen::MatrixXd inverse = all.inverse(), precision = z.transpose() * inverse * z;
  const Eigen::VectorXd mean = precision.ldlt().solve(z.transpose() * inverse * y);
  const double likelihood =
      log_normal_density(y, z * mean, all) - 0.5 * std::log(precision.determinant()) + std::log(2 * std::numbers::pi);
  const auto fit = fit_population_mean(units, covariance);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->population.mean - mean).norm(), 1e-10);
  EXPECT_LT((fit->population.mean_covariance - precision.inverse()).norm(), 1e-10);
  EXPECT_NEAR(fit->log_likelihood, likelihood, 1e-8);
}

TEST(Population, NeverLowersLikelihoodInIteration) {
  const Coefficients population{normal_vector(3, 1), random_covariance(3, 2)};
  const auto units = draw_units(population, 6, 10, 1, 3);
  const Eigen::MatrixXd start = Eigen::MatrixXd::Identity(3, 3);
  for (const PopulationOptions& kind : {PopulationOptions{}, PopulationOptions{.independent = true},
                                        PopulationOptions{.shrinkage = Shrinkage{Eigen::Vector3d(1, 0.5, 2), 4}}}) {
    double before = -1e300;
    for (int most = 0; most <= 40; ++most) {
      PopulationOptions options = kind;
      options.most_iterations = most;
      options.tolerance = -1;
      const auto fit = fit_population(units, start, options);
      ASSERT_TRUE(fit);
      EXPECT_GE(fit->log_likelihood, before - 1e-9) << most;
      before = fit->log_likelihood;
    }
  }
}

/// Each unit has one constant and n values with noise of variance 1. The restricted estimate of Σ is then the variance
/// of the unit means minus 1/n, as in the analysis of variance.
TEST(Population, MatchesAnalysisOfVarianceForBalancedConstants) {
  const Coefficients population{Eigen::VectorXd::Constant(1, 3), Eigen::MatrixXd::Constant(1, 1, 2)};
  std::vector<UnitInformation> units;
  Eigen::VectorXd means(9);
  for (Eigen::Index u = 0; u < 9; ++u) {
    const DenseUnit unit = draw_unit(population, 4, 1, static_cast<std::uint64_t>(u) + 1);
    units.push_back(information(unit, 1));
    means(u) = unit.y.mean();
  }
  const auto fit =
      fit_population(units, Eigen::MatrixXd::Identity(1, 1), {.most_iterations = 5000, .tolerance = 1e-12});
  ASSERT_TRUE(fit && fit->converged);
  const double variance = (means.array() - means.mean()).square().sum() / 8;
  EXPECT_NEAR(fit->population.mean(0), means.mean(), 1e-6);
  EXPECT_NEAR(fit->population.covariance(0, 0), variance - 0.25, 1e-4);
  EXPECT_NEAR(fit->population.mean_covariance(0, 0), variance / 9, 1e-4);
}

TEST(Population, FindsMeanAndCovarianceOfManyUnits) {
  const Coefficients population{Eigen::Vector3d(2, -1, 0.5), random_covariance(3, 5)};
  const auto units = draw_units(population, 600, 12, 1, 1);
  const auto fit = fit_population(units, Eigen::MatrixXd::Identity(3, 3), {.tolerance = 1e-6});
  ASSERT_TRUE(fit && fit->converged);
  EXPECT_LT((fit->population.mean - population.mean).norm(), 4 * std::sqrt(fit->population.mean_covariance.trace()));
  EXPECT_LT((fit->population.covariance - population.covariance).norm(), 0.12 * population.covariance.norm());
}

TEST(Population, HasDiagonalCovarianceWithoutCorrelations) {
  const Coefficients population{Eigen::Vector3d(2, -1, 0.5), Eigen::Vector3d(4, 1, 0.25).asDiagonal()};
  const auto units = draw_units(population, 300, 12, 1, 1);
  const auto fit = fit_population(units, Eigen::MatrixXd::Identity(3, 3), {.independent = true});
  ASSERT_TRUE(fit);
  const Eigen::MatrixXd& found = fit->population.covariance;
  EXPECT_TRUE(found.isDiagonal());
  // Four standard errors of a variance.
  for (Eigen::Index j = 0; j < 3; ++j)
    EXPECT_NEAR(found(j, j) / population.covariance(j, j), 1, 4 * std::sqrt(2.0 / 300)) << j;
}

/// The estimate is between the estimate without shrinkage and the target. It approaches the target with the weight.
TEST(Population, ShrinksTowardsTarget) {
  const Coefficients population{normal_vector(3, 1), random_covariance(3, 2)};
  const auto units = draw_units(population, 8, 200, 0.1, 4);
  const Eigen::MatrixXd start = Eigen::MatrixXd::Identity(3, 3);
  const Eigen::Vector3d target(1, 1, 1);
  const auto free = fit_population(units, start, {.tolerance = 1e-9});
  double before = 1e300;
  for (const double weight : {0.1, 1.0, 10.0, 1000.0}) {
    const auto fit = fit_population(units, start, {.shrinkage = Shrinkage{target, weight}, .tolerance = 1e-9});
    ASSERT_TRUE(free && fit);
    const double distance = (fit->population.covariance - Eigen::MatrixXd(target.asDiagonal())).norm();
    EXPECT_LT(distance, before);
    before = distance;
    // Exactly known coefficients give (S + κD)/(U − 1 + κ), with S the scatter matrix about their mean.
    const Eigen::MatrixXd expected =
        (7 * free->population.covariance + weight * Eigen::MatrixXd(target.asDiagonal())) / (7 + weight);
    EXPECT_LT((fit->population.covariance - expected).norm(), 0.02 * expected.norm());
  }
}

/// The interval of the prior from twelve units contains a linear combination of the next unit's coefficients in 90 to
/// 97 % of the draws. k = 2 gives slightly less than 95 %, because Σ has eleven degrees of freedom.
TEST(Population, HasNominalCoverageForNextUnit) {
  int within = 0;
  constexpr int kDraws = 400;
  const Coefficients population{Eigen::Vector2d(2, -1), Eigen::Vector2d(4, 1).asDiagonal()};
  const Eigen::Vector2d combination(1, 0.7);
  for (std::uint64_t draw = 1; draw <= kDraws; ++draw) {
    const auto units = draw_units(population, 12, 30, 1, draw);
    const auto fit = fit_population(units, Eigen::MatrixXd::Identity(2, 2));
    ASSERT_TRUE(fit);
    const Coefficients prior = next_unit(fit->population);
    const Eigen::Vector2d own = population.mean + Eigen::Vector2d(2, 1).cwiseProduct(normal_vector(2, draw + 777777));
    const double u = std::sqrt(combination.dot(prior.covariance * combination));
    within += std::abs(combination.dot(own - prior.mean)) <= 2 * u;
  }
  EXPECT_GT(within, 0.90 * kDraws);
  EXPECT_LT(within, 0.97 * kDraws);
}

TEST(Population, RejectsTooFewUnitsOrMissingInformation) {
  const Coefficients population{Eigen::Vector2d(2, -1), Eigen::Matrix2d::Identity()};
  const auto units = draw_units(population, 2, 10, 1, 1);
  const auto few = fit_population(units, Eigen::Matrix2d::Identity());
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().kind, FaultKind::usage);
  const std::vector<UnitInformation> uninformative(4, no_information(2));
  const auto unidentified = fit_population(uninformative, Eigen::Matrix2d::Identity());
  ASSERT_FALSE(unidentified);
  EXPECT_EQ(unidentified.error().kind, FaultKind::numeric);
}

}  // namespace
}  // namespace gyrotherm::population
