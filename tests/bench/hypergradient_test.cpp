// SPDX-License-Identifier: Apache-2.0
#include "bench/tuning/hypergradient.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "bench/tuning/descent.hpp"

namespace gyrotherm::bench {
namespace {

struct Samples {
  svm::SampleMatrix x;
  Eigen::VectorXd y;
};

Samples random_samples(std::mt19937_64& generator, Eigen::Index rows, Eigen::Index inputs) {
  std::normal_distribution<double> normal;
  Samples samples{svm::SampleMatrix::NullaryExpr(rows, inputs, [&] { return normal(generator); }), {}};
  samples.y.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i)
    samples.y[i] =
        std::sin(samples.x(i, 0)) + 0.3 * samples.x(i, inputs - 1) * samples.x(i, 0) + 0.1 * normal(generator);
  return samples;
}

/// Error of an almost exact solution. `pieces` states for each point whether β is −C, between, 0, between or C.
struct ExactError : SquaredError {
  std::vector<int> pieces;
};

/// Trains almost exactly and differentiates. Returns nothing if the certificate is missed.
std::optional<ExactError> exact_error(const Samples& training, const Samples& held_out, const Position& position) {
  const svm::SvrParameters parameters = parameters_at(position);
  const auto solution =
      svm::solve_svr(training.x, training.y, parameters, {.relative_gap = 1e-9, .max_newton_steps = 2000});
  if (!solution) return {};
  ExactError error{differentiate({training.x, held_out.x, held_out.y}, *solution, parameters), {}};
  for (const double beta : solution->beta)
    error.pieces.push_back((beta > 0) - (beta < 0) + (beta == parameters.C) - (beta == -parameters.C));
  return error;
}

/// Measures the slope by central differences. Returns nothing if a point changes its piece in between, because the
/// error has a kink there.
std::optional<Position> measured_slope(const Samples& training, const Samples& held_out, const Position& position,
                                       const ExactError& error) {
  constexpr double kStep = 1e-4;
  Position measured;
  for (int k = 0; k < 3; ++k) {
    const Position step = kStep * Position::Unit(k);
    const auto above = exact_error(training, held_out, position + step),
               below = exact_error(training, held_out, position - step);
    if (!above || !below || above->pieces != error.pieces || below->pieces != error.pieces) return {};
    measured[k] = (above->sum - below->sum) / (2 * kStep);
  }
  return measured;
}

TEST(Hypergradient, EqualsFiniteDifferences) {
  int compared = 0;
  for (int seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> part(0, 1);
    const auto rows = static_cast<Eigen::Index>(60 + 100 * part(generator));
    const auto inputs = static_cast<Eigen::Index>(1 + 5 * part(generator));
    const Samples training = random_samples(generator, rows, inputs), held_out = random_samples(generator, 40, inputs);
    const Position position(-2 + 12 * part(generator), -1 + 3 * part(generator), -7 + 5 * part(generator));
    const auto error = exact_error(training, held_out, position);
    const auto measured = error ? measured_slope(training, held_out, position, *error) : std::nullopt;
    if (!measured) continue;
    ++compared;
    EXPECT_LT((error->slope - *measured).norm(), 0.01 * measured->norm()) << error->slope << "\n\n" << *measured;
  }
  EXPECT_GE(compared, 30);
}

TEST(Hypergradient, IsZeroForCWithoutPointAtBound) {
  std::mt19937_64 generator(3);
  const Samples training = random_samples(generator, 60, 4), held_out = random_samples(generator, 40, 4);
  const auto error = exact_error(training, held_out, {12, 0, -4});
  ASSERT_TRUE(error);
  EXPECT_EQ(error->slope[0], 0);
  EXPECT_NE(error->slope[1], 0);
}

TEST(Descent, BestStepIsLeastInBox) {
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> part(0, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Matrix3d root = Eigen::Matrix3d::NullaryExpr([&] { return normal(generator); });
    const Eigen::Matrix3d curvature = root * root.transpose() + 1e-3 * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d slope = Eigen::Vector3d::NullaryExpr([&] { return 3 * normal(generator); });
    // Some sides of the box are at the position itself.
    const Eigen::Vector3d lower = Eigen::Vector3d::NullaryExpr([&] { return -std::floor(3 * part(generator)); });
    const Eigen::Vector3d upper = Eigen::Vector3d::NullaryExpr([&] { return std::floor(3 * part(generator)); });
    const Eigen::Vector3d step = best_step(slope, curvature, lower, upper);
    const auto value = [&](const Eigen::Vector3d& at) { return slope.dot(at) + 0.5 * at.dot(curvature * at); };
    EXPECT_TRUE((step.array() >= lower.array()).all() && (step.array() <= upper.array()).all());
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector3d other =
          lower + (upper - lower).cwiseProduct(Eigen::Vector3d::NullaryExpr([&] { return part(generator); }));
      EXPECT_LE(value(step), value(other) + 1e-12);
    }
  }
}

/// Four folds of one set; each holds out a quarter.
std::vector<svm::TuningFold> four_folds(const Samples& samples) {
  std::vector<svm::TuningFold> folds(4);
  for (int f = 0; f < 4; ++f) {
    std::vector<Eigen::Index> training, held_out;
    for (Eigen::Index i = 0; i < samples.y.size(); ++i) (i % 4 == f ? held_out : training).push_back(i);
    folds[f] = {.train_x = samples.x(training, Eigen::all),
                .train_y = samples.y(training),
                .test_x = samples.x(held_out, Eigen::all),
                .test_y = samples.y(held_out),
                .target_scale = 0.5,
                .train_rows = training};
  }
  return folds;
}

TEST(Descent, StaysInBoxAndCountsEvaluations) {
  std::mt19937_64 generator(8);
  const auto folds = four_folds(random_samples(generator, 120, 3));
  FoldErrors errors(folds, 1e-4), again(folds, 1e-4);
  const DescentOptions options{.screened = 8, .descents = 2, .most_evaluations = 20};
  const DescentResult found = descend(errors, options);
  EXPECT_LE(errors.evaluations(), 20);
  const svm::TuningOptions box;
  EXPECT_GE(found.best[0], box.log2_c.first);
  EXPECT_LE(found.best[0], box.log2_c.second);
  EXPECT_GE(found.best[1], box.log2_sigma.first);
  EXPECT_LE(found.best[1], box.log2_sigma.second);
  EXPECT_GE(found.best[2], box.log2_epsilon.first);
  EXPECT_LE(found.best[2], box.log2_epsilon.second);
  const auto error = svm::cross_validation_error(folds, parameters_at(found.best), {.relative_gap = 1e-6}, 1e9);
  ASSERT_TRUE(error);
  EXPECT_NEAR(std::log(*error), found.log_error, 5e-3);
  EXPECT_EQ(descend(again, options).best, found.best) << "no random numbers";
}

}  // namespace
}  // namespace gyrotherm::bench
