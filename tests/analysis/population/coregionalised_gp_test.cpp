// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/coregionalised_gp.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/methods/kernel_methods.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::population {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

Coregionalisation some_model() {
  Coregionalisation model{.lengths = Eigen::RowVector2d(0.8, 1.7), .root = Eigen::Matrix3d::Zero(), .noise = {}};
  model.root << 1.2, 0, 0, 0.7, 0.5, 0, -0.4, 0.3, 0.9;
  model.noise = Eigen::Vector3d(0.3, 0.5, 0.2);
  return model;
}

/// Returns B ⊗ k for all outputs at all rows, output by output.
Eigen::MatrixXd kronecker(const Coregionalisation& model, const data::SampleMatrix& a, const data::SampleMatrix& b) {
  const Eigen::MatrixXd kernel = methods::covariance_matrix({model.lengths, 1, 0}, a, b);
  const Eigen::MatrixXd between = output_covariance(model);
  const Eigen::Index outputs = between.rows();
  Eigen::MatrixXd all(outputs * a.rows(), outputs * b.rows());
  for (Eigen::Index i = 0; i < outputs; ++i)
    for (Eigen::Index j = 0; j < outputs; ++j)
      all.block(i * a.rows(), j * b.rows(), a.rows(), b.rows()) = between(i, j) * kernel;
  return all;
}

/// Returns the noise variance of each output at each row, output by output.
Eigen::VectorXd noise_variances(const Coregionalisation& model, Eigen::Index rows) {
  Eigen::VectorXd all(model.noise.size() * rows);
  for (Eigen::Index j = 0; j < model.noise.size(); ++j)
    all.segment(j * rows, rows).setConstant(model.noise(j) * model.noise(j));
  return all;
}

/// Draws a table from the model, with one column per output.
Eigen::MatrixXd draw_table(const Coregionalisation& model, const data::SampleMatrix& x, std::uint64_t seed) {
  Eigen::MatrixXd covariance = kronecker(model, x, x);
  covariance.diagonal() += noise_variances(model, x.rows());
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  const Eigen::VectorXd values = root * data::normal_vector(covariance.rows(), seed);
  return values.reshaped(x.rows(), model.noise.size());
}

/// The process in dense form. The constant of each output is a further process with the large variance V, which
/// represents a flat prior.
struct DenseProcess {
  Eigen::MatrixXd covariance;  ///< known values
  Eigen::VectorXd y;
  /// Covariance of the predicted values (rows) with the known ones (columns).
  Eigen::MatrixXd cross_covariance;
  Eigen::VectorXd prior_variance;   ///< predicted values
  std::vector<Eigen::Index> known;  ///< indices of the known values
};

constexpr double kUnknownConstant = 1e6;  // variance

/// Returns a matrix that is 1 for each pair of values of the same output and 0 elsewhere.
Eigen::MatrixXd same_output(Eigen::Index outputs, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(outputs * rows, outputs * columns);
  for (Eigen::Index j = 0; j < outputs; ++j) all.block(j * rows, j * columns, rows, columns).setOnes();
  return all;
}

DenseProcess dense_process(const Coregionalisation& model, const data::SampleMatrix& x, const Eigen::MatrixXd& table,
                           const data::SampleMatrix& at) {
  const Eigen::Index outputs = model.noise.size();
  DenseProcess dense;
  for (Eigen::Index i = 0; i < table.size(); ++i)
    if (!std::isnan(table.reshaped()(i))) dense.known.push_back(i);
  Eigen::MatrixXd all = kronecker(model, x, x) + kUnknownConstant * same_output(outputs, x.rows(), x.rows());
  all.diagonal() += noise_variances(model, x.rows());
  const Eigen::MatrixXd cross = kronecker(model, at, x) + kUnknownConstant * same_output(outputs, at.rows(), x.rows());
  dense.covariance = all(dense.known, dense.known);
  dense.cross_covariance = cross(Eigen::all, dense.known);
  dense.y = table.reshaped()(dense.known);
  dense.prior_variance = kronecker(model, at, at).diagonal().array() + kUnknownConstant;
  return dense;
}

/// Requires that predictions and likelihood agree with those of the dense process.
void expect_agreement_with_dense_process(const Coregionalisation& model, const data::SampleMatrix& x,
                                         const Eigen::MatrixXd& table) {
  const data::SampleMatrix at = data::normal_matrix(5, 2, 2);
  const auto process = condition(model, samples_from_table(x, table));
  ASSERT_TRUE(process);
  const DenseProcess dense = dense_process(model, x, table, at);
  ASSERT_EQ(process->samples.values.size(), dense.known.size());
  const Eigen::LDLT<Eigen::MatrixXd> factor(dense.covariance);
  const auto predicted = predict(*process, at);
  EXPECT_LT((predicted.mean.reshaped() - dense.cross_covariance * factor.solve(dense.y)).norm(), 1e-4);
  const Eigen::VectorXd variance =
      dense.prior_variance - (dense.cross_covariance * factor.solve(dense.cross_covariance.transpose())).diagonal();
  EXPECT_LT((predicted.variance.reshaped() - variance).norm(), 1e-4);
  // The likelihoods differ by the density of the constants, which is nearly flat in the dense process.
  const double flat = 0.5 * 3 * std::log(2 * std::numbers::pi * kUnknownConstant);
  EXPECT_NEAR(process->log_likelihood,
              -0.5 * dense.y.dot(factor.solve(dense.y)) - 0.5 * factor.vectorD().array().log().sum() -
                  0.5 * static_cast<double>(dense.y.size()) * std::log(2 * std::numbers::pi) + flat,
              1e-3);
}

TEST(CoregionalisedGp, MatchesDenseProcessWithKroneckerProduct) {
  const data::SampleMatrix x = data::normal_matrix(12, 2, 1);
  expect_agreement_with_dense_process(some_model(), x, draw_table(some_model(), x, 3).array() + 0.7);
}

TEST(CoregionalisedGp, OmitsMissingValues) {
  const data::SampleMatrix x = data::normal_matrix(10, 2, 1);
  Eigen::MatrixXd table = draw_table(some_model(), x, 3);
  for (Eigen::Index i = 1; i < table.size(); i += 4) table.reshaped()(i) = kMissing;
  expect_agreement_with_dense_process(some_model(), x, table);
}

TEST(CoregionalisedGp, HasGradientOfItsLikelihood) {
  const data::SampleMatrix x = data::normal_matrix(9, 2, 1);
  Eigen::MatrixXd table = draw_table(some_model(), x, 4);
  table(2, 1) = table(7, 0) = kMissing;
  const OutputSamples samples = samples_from_table(x, table);
  const auto at = marginal_likelihood(some_model(), samples);
  ASSERT_TRUE(at);
  ASSERT_EQ(at->gradient.size(), 11);
  constexpr double kStep = 1e-5;
  const auto moved = [](Eigen::Index k, double by) {
    Coregionalisation model = some_model();
    if (k < 2) model.lengths(k) *= std::exp(by);
    if (k >= 8) model.noise(k - 8) *= std::exp(by);
    constexpr std::pair<int, int> kEntries[] = {{0, 0}, {1, 0}, {2, 0}, {1, 1}, {2, 1}, {2, 2}};
    if (k < 2 || k >= 8) return model;
    const auto [row, column] = kEntries[k - 2];
    row == column ? model.root(row, column) *= std::exp(by) : model.root(row, column) += by;
    return model;
  };
  for (Eigen::Index k = 0; k < 11; ++k) {
    const double slope = (marginal_likelihood(moved(k, kStep), samples)->log_value -
                          marginal_likelihood(moved(k, -kStep), samples)->log_value) /
                         (2 * kStep);
    EXPECT_NEAR(at->gradient(k), slope, 1e-6 * std::max(1.0, std::abs(slope))) << k;
  }
}

/// The single-output process has no constant, so its likelihood is integrated over the constant.
TEST(CoregionalisedGp, MatchesSingleOutputProcess) {
  const data::SampleMatrix x = data::normal_matrix(20, 2, 1);
  const Eigen::VectorXd y = data::normal_vector(20, 2);
  const methods::Covariance covariance{Eigen::RowVector2d(0.7, 1.4), 0.8, 0.4};
  const Coregionalisation model{covariance.lengths, Eigen::MatrixXd::Constant(1, 1, 0.8),
                                Eigen::VectorXd::Constant(1, 0.4)};
  double sum = 0;
  constexpr double kStep = 0.01;
  for (double constant = -6; constant < 6; constant += kStep)
    sum += kStep * std::exp(methods::marginal_likelihood(covariance, x, y.array() - constant)->log_value);
  const auto found = marginal_likelihood(model, samples_from_table(x, y));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->log_value, std::log(sum), 1e-6);
}

/// Autokrigeability: without noise, outputs that are known at the same rows do not improve each other's prediction.
TEST(CoregionalisedGp, GainsNothingWithoutNoiseAndGaps) {
  Coregionalisation model = some_model();
  model.noise.setConstant(1e-5);
  const data::SampleMatrix x = 2 * data::normal_matrix(8, 2, 1), at = data::normal_matrix(5, 2, 2);
  const Eigen::MatrixXd table = draw_table(model, x, 3);
  const auto together = condition(model, samples_from_table(x, table));
  const auto alone =
      condition({model.lengths, Eigen::MatrixXd::Constant(1, 1, 1.2), Eigen::VectorXd::Constant(1, 1e-5)},
                samples_from_table(x, table.leftCols(1)));
  ASSERT_TRUE(together && alone);
  EXPECT_LT((predict(*together, at).mean.col(0) - predict(*alone, at).mean.col(0)).norm(), 1e-5);
}

/// Returns the times 0 … rows − 1 as multiples of the kernel length.
data::SampleMatrix scaled_times(Eigen::Index rows, double length) {
  data::SampleMatrix time(rows, 1);
  for (Eigen::Index k = 0; k < rows; ++k) time(k, 0) = static_cast<double>(k) / length;
  return time;
}

Coregionalisation two_correlated_outputs(double correlation) {
  Coregionalisation model{.lengths = Eigen::RowVectorXd::Ones(1), .root = Eigen::Matrix2d::Zero(), .noise = {}};
  model.root << 1, 0, correlation, std::sqrt(1 - correlation * correlation);
  model.noise = Eigen::Vector2d(0.3, 0.6);
  return model;
}

TEST(CoregionalisedGp, LearnsCorrelationBetweenOutputs) {
  for (const double correlation : {0.0, 0.9, -0.7}) {
    double mean = 0;
    Eigen::Vector2d noise = Eigen::Vector2d::Zero();
    constexpr int kDraws = 5;
    for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
      const data::SampleMatrix time = scaled_times(100, 2);
      const auto process = learn_coregionalised(
          samples_from_table(time, 1e-3 * draw_table(two_correlated_outputs(correlation), time, seed)));
      ASSERT_TRUE(process);
      mean += correlation_between_outputs(process->model)(0, 1) / kDraws;
      noise += 1e3 * process->model.noise / kDraws;
    }
    // Two standard errors, for five draws with 50 kernel lengths each.
    EXPECT_NEAR(mean, correlation, 0.15);
    EXPECT_LT((noise - Eigen::Vector2d(0.3, 0.6)).norm(), 0.06);
  }
}

/// The first output has a gap in which the second one has values.
TEST(CoregionalisedGp, FillsGapFromCorrelatedOutput) {
  double together_error = 0, alone_error = 0, within = 0;
  constexpr int kDraws = 12;
  for (std::uint64_t seed = 1; seed <= kDraws; ++seed) {
    const Coregionalisation model = two_correlated_outputs(0.95);
    const data::SampleMatrix time = scaled_times(80, 6), gap = time.middleRows(30, 20);
    Eigen::MatrixXd table = draw_table(model, time, seed);
    const Eigen::VectorXd hidden = table.col(0).segment(30, 20);
    table.col(0).segment(30, 20).setConstant(kMissing);
    const auto together = learn_coregionalised(samples_from_table(time, table));
    const auto alone = learn_coregionalised(samples_from_table(time, table.leftCols(1)));
    ASSERT_TRUE(together && alone);
    const auto predicted = predict(*together, gap);
    const Eigen::ArrayXd error = predicted.mean.col(0) - hidden;
    const double noise = together->model.noise(0);
    together_error += error.square().sum();
    alone_error += (predict(*alone, gap).mean.col(0) - hidden).squaredNorm();
    within +=
        (error.square() <= 4 * (predicted.variance.col(0).array() + noise * noise)).cast<double>().mean() / kDraws;
  }
  EXPECT_LT(together_error, 0.4 * alone_error);
  EXPECT_GT(within, 0.85);
}

TEST(CoregionalisedGp, RejectsInvalidSamples) {
  const data::SampleMatrix x = data::normal_matrix(5, 1, 1);
  const auto refuses = [](OutputSamples samples) {
    const auto process = learn_coregionalised(std::move(samples));
    return !process && process.error().kind == FaultKind::usage;
  };
  Eigen::MatrixXd table = data::normal_matrix(5, 2, 2);
  EXPECT_TRUE(refuses({x, {{0, 0, 1}, {9, 0, 2}}, 1}));
  EXPECT_TRUE(refuses({x, {{0, 0, 1}, {1, 1, 2}}, 1}));
  EXPECT_TRUE(refuses({x, {{0, 0, 1}, {1, 0, std::numeric_limits<double>::infinity()}}, 1}));
  table.col(1).tail(4).setConstant(kMissing);
  EXPECT_TRUE(refuses(samples_from_table(x, table)));
  table.col(1).setConstant(3);
  EXPECT_TRUE(refuses(samples_from_table(x, table)));
}

}  // namespace
}  // namespace gyrotherm::population
