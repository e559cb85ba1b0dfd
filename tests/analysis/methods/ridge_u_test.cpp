// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/ridge_u.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "analysis/methods/linear.hpp"
#include "analysis/model/model.hpp"
#include "analysis/model/training.hpp"
#include "tests/analysis/random_samples.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::methods {
namespace {

Eigen::MatrixXd some_covariance(Eigen::Index inputs, std::uint64_t seed) {
  const Eigen::MatrixXd root = 0.3 * data::normal_matrix(inputs, inputs, seed);
  return root.transpose() * root;
}

TEST(RidgeU, SolvesNormalEquations) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const data::Samples samples = data::bent_samples(60, 4, 0.1, seed);
    const Eigen::MatrixXd covariance = some_covariance(4, seed);
    const PenalisedPlane plane = penalised_plane(samples.x, samples.y, covariance);
    const Eigen::MatrixXd z = samples.x.rowwise() - samples.x.colwise().mean();
    const Eigen::VectorXd y = samples.y.array() - samples.y.mean();
    const Eigen::MatrixXd normal = z.transpose() * z + 60 * covariance;
    EXPECT_LT((normal * plane.weights - z.transpose() * y).norm(), 1e-10);
    EXPECT_NEAR(plane.b, samples.y.mean() - samples.x.colwise().mean() * plane.weights, 1e-12);
    EXPECT_NEAR(plane.effective_parameters, 1 + (z * normal.ldlt().solve(z.transpose())).trace(), 1e-10);
  }
}

TEST(RidgeU, EqualsLeastSquaresForExactInputs) {
  const data::Samples samples = data::bent_samples(50, 3, 0.1, 1);
  const auto ridge = fit_ridge_u(samples.set(), {}, {}), least = fit_linear(samples.set(), {}, {});
  ASSERT_TRUE(ridge && least);
  const auto &one = std::get<LinearModel>(ridge->function), &other = std::get<LinearModel>(least->function);
  EXPECT_LT((one.weights - other.weights).norm(), 1e-12);
  EXPECT_NEAR(one.b, other.b, 1e-12);
  EXPECT_NEAR(ridge->effective_parameters, 4, 1e-10);
}

/// The plane is trained on exact samples and used with erroneous readings. Any other plane must have a larger error.
TEST(RidgeU, HasLowestErrorOnReadingsWithErrors) {
  const Eigen::Index rows = 400;
  data::Samples samples{data::normal_matrix(rows, 3, 1), {}, data::letters(3)};
  // Makes two thermometers nearly collinear.
  samples.x.col(2) = samples.x.col(1) + 0.05 * samples.x.col(2);
  samples.y = samples.x.col(1) + 3 * (samples.x.col(2) - samples.x.col(1)) + 0.1 * data::normal_vector(rows, 2);
  const Eigen::MatrixXd covariance = Eigen::Vector3d(0.01, 0.04, 0.09).asDiagonal();
  const PenalisedPlane plane = penalised_plane(samples.x, samples.y, covariance);
  const Eigen::MatrixXd root = covariance.llt().matrixL().transpose();
  const auto mean_error = [&](const Eigen::VectorXd& weights) {
    double sum = 0;
    for (std::uint64_t draw = 0; draw < 200; ++draw) {
      const Eigen::MatrixXd read = samples.x + data::normal_matrix(rows, 3, 1000 + draw) * root;
      const Eigen::VectorXd residual = samples.y - read * weights;
      sum += (residual.array() - (samples.y - samples.x * weights).mean()).matrix().squaredNorm();
    }
    return sum / (200 * static_cast<double>(rows));
  };
  const double least = mean_error(plane.weights);
  const Eigen::VectorXd residual = samples.y - samples.x * plane.weights;
  const double expected = (residual.array() - residual.mean()).matrix().squaredNorm() / static_cast<double>(rows) +
                          plane.weights.dot(covariance * plane.weights);
  EXPECT_NEAR(least, expected, 0.02 * expected);
  const Eigen::VectorXd exact = penalised_plane(samples.x, samples.y, Eigen::Matrix3d::Zero()).weights;
  // Moves towards least squares and away from it.
  for (const double part : {-0.5, 0.25, 0.5, 1.0})
    EXPECT_GT(mean_error(plane.weights + part * (exact - plane.weights)), least) << part;
  for (const double penalty : {0.1, 10.0})
    EXPECT_GT(mean_error(penalised_plane(samples.x, samples.y, penalty * covariance).weights), least) << penalty;
}

TEST(RidgeU, DependsOnlyOnSpanOfTerms) {
  const data::Clusters clusters = *data::make_clusters(data::make_synthetic_run({}));
  const data::Dataset dataset = data::make_synthetic_run({});
  model::TrainingOptions options;
  options.method = "ridge-u";
  options.inputs = "temperatures";
  const auto plain = train({dataset}, {clusters}, options);
  options.inputs = "A,seven-point";
  const auto turned = train({dataset}, {clusters}, options);
  ASSERT_TRUE(plain && turned);
  EXPECT_LT((*predict(*plain, clusters) - *predict(*turned, clusters)).cwiseAbs().maxCoeff(), 1e-9);
}

/// The inputs are one temperature and all 28 gradients of eight thermometers, which are dependent. Large weights that
/// cancel would cause large errors when one input is clamped to its range.
TEST(RidgeU, HasSmallWeightsForDependentTerms) {
  const data::Dataset dataset = data::make_synthetic_run({});
  model::TrainingOptions options;
  options.method = "ridge-u";
  options.inputs = "gradients,A";
  const auto model = train({dataset}, {*make_clusters(dataset)}, options);
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_LT(std::get<LinearModel>(model->function).weights.lpNorm<Eigen::Infinity>(), 3);
}

constexpr const char* kAssumed = "the record contains no uncertainty of its thermometers: 0.05 K is assumed";

TEST(RidgeU, MatchesClosedFormOnRawTemperatures) {
  data::Dataset dataset = data::make_synthetic_run({});
  const auto u = Eigen::VectorXd::LinSpaced(8, 0.01, 0.08).eval();
  for (const double each : u)
    dataset.thermometer_uncertainty.push_back(
        {.calibration = Kelvins{0.6 * each}, .drift_in_a_year = Kelvins{0.8 * each}});
  const data::Clusters clusters = *make_clusters(dataset);
  model::TrainingOptions options;
  options.method = "ridge-u";
  const auto model = train({dataset}, {clusters}, options);
  ASSERT_TRUE(model) << text(model.error());
  const Eigen::MatrixXd t = clusters.temperature_c.rowwise() - clusters.temperature_c.colwise().mean();
  const double mean = clusters.bias_deg_per_h.mean();
  Eigen::MatrixXd normal = t.transpose() * t;
  normal.diagonal() += static_cast<double>(t.rows()) * u.cwiseAbs2();
  const Eigen::VectorXd weights =
      normal.fullPivLu().solve(t.transpose() * (clusters.bias_deg_per_h.array() - mean).matrix());
  const Eigen::VectorXd expected = (t * weights).array() + mean;
  EXPECT_LT((*predict(*model, clusters) - expected).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(std::ranges::count(model->warnings, kAssumed), 0);
}

TEST(RidgeU, ReportsAssumedUncertainty) {
  const data::Dataset dataset = data::make_synthetic_run({});
  model::TrainingOptions options;
  options.method = "ridge-u";
  options.inputs = "thermal-history";
  const auto model = train({dataset}, {*make_clusters(dataset)}, options);
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_EQ(model->terms.size(), 48u);
  EXPECT_EQ(std::ranges::count(model->warnings, kAssumed), 1);
  const auto again = model::model_from_json(to_json(*model), "model.json");
  ASSERT_TRUE(again) << text(again.error());
  EXPECT_EQ(again->terms, model->terms);
}

}  // namespace
}  // namespace gyrotherm::methods
