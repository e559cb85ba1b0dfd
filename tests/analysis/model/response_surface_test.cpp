// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "analysis/model/selection.hpp"

namespace gyrotherm::model {
namespace {

svm::SampleMatrix random_matrix(std::mt19937_64& random, Eigen::Index rows, Eigen::Index columns) {
  std::normal_distribution<double> normal;
  return svm::SampleMatrix::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Returns a function of second order in three inputs.
Eigen::VectorXd quadratic(const svm::SampleMatrix& x) {
  return (1.5 + 2 * x.col(0).array() - x.col(1).array() * x.col(2).array() + 0.7 * x.col(2).array().square()).matrix();
}

TEST(ResponseSurface, RecoversQuadraticFunction) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const svm::SampleMatrix x = 3 * random_matrix(random, 60, 3), unseen = 5 * random_matrix(random, 20, 3);
    const std::array lambda = {1e-12};
    const Eigen::VectorXd predicted = surface_predictions(x, quadratic(x), unseen, lambda);
    EXPECT_LT((predicted - quadratic(unseen)).cwiseAbs().maxCoeff(), 1e-6);
  }
}

/// Predicts the targets with ridge regression on standardised products, as defined by the normal equations.
Eigen::VectorXd predict_by_definition(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                      const svm::SampleMatrix& test, double lambda) {
  const auto standardised = [](const svm::SampleMatrix& from, const svm::SampleMatrix& values) {
    const Eigen::RowVectorXd mean = from.colwise().mean();
    const Eigen::RowVectorXd std =
        ((from.rowwise() - mean).colwise().squaredNorm() / static_cast<double>(from.rows())).cwiseSqrt();
    return svm::SampleMatrix((values.rowwise() - mean).array().rowwise() / std.array());
  };
  const auto products = [](const svm::SampleMatrix& z) {
    svm::SampleMatrix all(z.rows(), 5);
    all << z, z.col(0).cwiseProduct(z.col(0)), z.col(0).cwiseProduct(z.col(1)), z.col(1).cwiseProduct(z.col(1));
    return all;
  };
  const svm::SampleMatrix raw = products(standardised(x, x)), raw_test = products(standardised(x, test));
  const Eigen::MatrixXd a = standardised(raw, raw);
  const Eigen::MatrixXd normal =
      a.transpose() * a + lambda * static_cast<double>(x.rows()) * Eigen::MatrixXd::Identity(5, 5);
  const Eigen::VectorXd w = normal.fullPivLu().solve(a.transpose() * (y.array() - y.mean()).matrix());
  return (standardised(raw, raw_test) * w).array() + y.mean();
}

TEST(ResponseSurface, EqualsRidgeRegressionOnStandardisedProducts) {
  std::mt19937_64 random(7);
  const svm::SampleMatrix x = random_matrix(random, 30, 2), test = random_matrix(random, 9, 2);
  const Eigen::VectorXd y = random_matrix(random, 30, 1);
  const Eigen::MatrixXd predicted = surface_predictions(x, y, test, kSurfaceLambdas);
  for (std::size_t l = 0; l < kSurfaceLambdas.size(); ++l) {
    EXPECT_LT((predicted.col(l) - predict_by_definition(x, y, test, kSurfaceLambdas[l])).cwiseAbs().maxCoeff(), 1e-8)
        << kSurfaceLambdas[l];
  }
}

TEST(ResponseSurface, IgnoresConstantInput) {
  std::mt19937_64 random(8);
  svm::SampleMatrix x = random_matrix(random, 30, 2), test = random_matrix(random, 9, 2);
  const Eigen::VectorXd y = random_matrix(random, 30, 1);
  const Eigen::MatrixXd without = surface_predictions(x, y, test, kSurfaceLambdas);
  x.conservativeResize(Eigen::NoChange, 3);
  test.conservativeResize(Eigen::NoChange, 3);
  x.col(2).setConstant(20.1);
  test.col(2).setConstant(20.1);
  EXPECT_TRUE(surface_predictions(x, y, test, kSurfaceLambdas).isApprox(without, 1e-9));
}

TEST(ResponseSurface, PredictsMeanWithoutInputs) {
  const Eigen::VectorXd y = Eigen::Vector3d{1, 2, 6};
  const Eigen::MatrixXd predicted =
      surface_predictions(svm::SampleMatrix(3, 0), y, svm::SampleMatrix(2, 0), kSurfaceLambdas);
  EXPECT_EQ(predicted, Eigen::MatrixXd::Constant(2, kSurfaceLambdas.size(), 3));
}

TEST(ResponseSurface, EvaluatesOnHeldOutRows) {
  std::mt19937_64 random(9);
  const svm::SampleMatrix x = random_matrix(random, 40, 3);
  const Eigen::VectorXd y = quadratic(x) + 0.01 * random_matrix(random, 40, 1);
  data::FoldPlan folds;
  for (Eigen::Index first = 0; first < 40; first += 10) {
    data::Fold rows;
    for (Eigen::Index k = 0; k < 40; ++k) (k >= first && k < first + 10 ? rows.held_out : rows.training).push_back(k);
    folds.folds.push_back(rows);
  }
  const SurfaceTrial trial = try_surface(x, y, folds);
  EXPECT_NEAR(trial.mean_square, trial.residual.squaredNorm() / 40, 1e-15);
  const std::array lambda = {trial.lambda};
  for (const data::Fold& fold : folds.folds) {
    const Eigen::VectorXd predicted =
        surface_predictions(x(fold.training, Eigen::all), y(fold.training), x(fold.held_out, Eigen::all), lambda);
    EXPECT_TRUE(predicted.isApprox(y(fold.held_out) - trial.residual(fold.held_out), 1e-12));
  }
  EXPECT_LT(trial.mean_square, 1e-3);
}

}  // namespace
}  // namespace gyrotherm::model
