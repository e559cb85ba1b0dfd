// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/radial_basis.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>

#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

Eigen::Index nearest_to(const data::SampleMatrix& centres, const Eigen::RowVectorXd& sample) {
  Eigen::Index nearest = 0;
  (centres.rowwise() - sample).rowwise().squaredNorm().minCoeff(&nearest);
  return nearest;
}

TEST(KMeans, NeverRaisesCost) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const data::SampleMatrix samples = data::normal_matrix(200, 3, seed);
    const auto found = k_means(samples, 12, seed);
    ASSERT_TRUE(found) << seed;
    for (std::size_t round = 1; round < found->costs.size(); ++round) {
      EXPECT_LE(found->costs[round], found->costs[round - 1] * (1 + 1e-14)) << "seed " << seed << " round " << round;
    }
  }
}

TEST(KMeans, EndsWithCentresAtMeansOfSamples) {
  const data::SampleMatrix samples = data::normal_matrix(300, 2, 9);
  const auto found = k_means(samples, 8, 9);
  ASSERT_TRUE(found);
  for (Eigen::Index k = 0; k < 8; ++k) {
    Eigen::RowVector2d sum{0, 0};
    double count = 0;
    for (Eigen::Index i = 0; i < 300; ++i) {
      if (nearest_to(found->centres, samples.row(i)) != k) continue;
      sum += samples.row(i);
      count += 1;
    }
    ASSERT_GT(count, 0);
    EXPECT_LT((found->centres.row(k) - sum / count).norm(), 1e-12);
  }
}

TEST(KMeans, FindsSeparatedClusters) {
  data::SampleMatrix samples = 0.01 * data::normal_matrix(90, 2, 4);
  for (Eigen::Index i = 0; i < 90; ++i) samples(i, 0) += static_cast<double>(i % 3) * 10;
  const auto found = k_means(samples, 3, 1);
  ASSERT_TRUE(found);
  Eigen::VectorXd first = found->centres.col(0);
  std::ranges::sort(first);
  EXPECT_LT((first - Eigen::Vector3d{0, 10, 20}).norm(), 0.05);
}

TEST(KMeans, RejectsTooFewDifferentSamples) {
  data::SampleMatrix samples = data::SampleMatrix::Zero(30, 2);
  samples.topRows(10).setOnes();
  const auto found = k_means(samples, 3, 1);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().what.find("distinct samples, got 2"), std::string::npos) << text(found.error());
  EXPECT_TRUE(k_means(samples, 2, 1));
  EXPECT_FALSE(k_means(samples, 31, 1));
}

TEST(SelfOrganisingMap, KeepsNeighboursClose) {
  const data::SampleMatrix samples = data::normal_matrix(800, 2, 3);
  const data::SampleMatrix nodes = self_organising_map(samples, 1, {.side = 6, .rounds = 30});
  double neighbours = 0, all = 0;
  for (Eigen::Index j = 0; j < 36; ++j) {
    if (j % 6 < 5) neighbours += (nodes.row(j) - nodes.row(j + 1)).norm() / 60;
    if (j < 30) neighbours += (nodes.row(j) - nodes.row(j + 6)).norm() / 60;
    for (Eigen::Index k = 0; k < 36; ++k) all += (nodes.row(j) - nodes.row(k)).norm() / 1260;
  }
  EXPECT_LT(neighbours, 0.4 * all);
  for (Eigen::Index k = 0; k < 2; ++k) {
    EXPECT_GE(nodes.col(k).minCoeff(), samples.col(k).minCoeff()) << "nodes are within the range of the samples";
    EXPECT_LE(nodes.col(k).maxCoeff(), samples.col(k).maxCoeff());
  }
}

TEST(NeighbourDistances, AverageTwoNearest) {
  const data::SampleMatrix centres = (data::SampleMatrix(4, 1) << 0, 1, 3, 10).finished();
  EXPECT_EQ(neighbour_distances(centres), Eigen::Vector4d(2, 1.5, 2.5, 8));
  const data::SampleMatrix reduced_gyros = (data::SampleMatrix(3, 1) << 0, 0, 4).finished();
  EXPECT_EQ(neighbour_distances(reduced_gyros), Eigen::Vector3d(2, 2, 4));
}

TEST(OrthogonalLeastSquares, HasRatiosThatSumToExplainedShare) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Eigen::MatrixXd candidates = data::normal_matrix(40, 10, seed);
    const Eigen::VectorXd y = candidates.col(2) - 0.5 * candidates.col(7) + 0.3 * data::normal_vector(40, seed + 50);
    const auto path = orthogonal_least_squares(candidates, y, 0, 10);
    ASSERT_EQ(path.order.size(), 10u);
    const Eigen::VectorXd centred = y.array() - y.mean();
    double explained = 0;
    for (Eigen::Index count = 1; count <= 10; ++count) {
      explained += path.ratios[static_cast<std::size_t>(count) - 1];
      const Eigen::VectorXd weights = path_weights(path, count);
      const std::vector<Eigen::Index> taken(path.order.begin(), path.order.begin() + count);
      Eigen::MatrixXd design(40, count + 1);
      design << candidates(Eigen::all, taken), Eigen::VectorXd::Ones(40);
      const Eigen::VectorXd oracle = design.householderQr().solve(y);
      EXPECT_LT((weights - oracle.head(count)).cwiseAbs().maxCoeff(), 1e-10);
      EXPECT_NEAR(path_offset(path, weights), oracle(count), 1e-10);
      EXPECT_NEAR(1 - explained, (y - design * oracle).squaredNorm() / centred.squaredNorm(), 1e-12);
    }
  }
}

TEST(OrthogonalLeastSquares, SelectsLargestRatioFirstAndStopsAtTolerance) {
  const Eigen::MatrixXd candidates = data::normal_matrix(60, 6, 2);
  const Eigen::VectorXd y = 3 * candidates.col(4) + 0.5 * candidates.col(1) + 0.01 * data::normal_vector(60, 3);
  const auto path = orthogonal_least_squares(candidates, y, 0.01, 6);
  EXPECT_EQ(path.order, (std::vector<Eigen::Index>{4, 1}));
  const auto whole = orthogonal_least_squares(candidates, y, 0, 6);
  EXPECT_EQ(count_selected(whole, 0.01), 2);
  EXPECT_EQ(count_selected(whole, 0), 6);
  EXPECT_EQ(count_selected(whole, 2), 0);
}

TEST(OrthogonalLeastSquares, SkipsCopiedCandidate) {
  Eigen::MatrixXd candidates = data::normal_matrix(30, 3, 2);
  candidates.col(2) = 2 * candidates.col(0);
  EXPECT_EQ(orthogonal_least_squares(candidates, data::normal_vector(30, 3), 0, 3).order.size(), 2u);
}

TEST(RadialBasisNetwork, FitsSumOfOwnUnits) {
  for (const double factor : {1.0, 1.5}) {
    data::Samples samples{data::normal_matrix(200, 2, 5), {}, data::letters(2)};
    const auto found = k_means(samples.x, 10, 1);
    const Eigen::VectorXd widths = factor * neighbour_distances(found->centres), weights = data::normal_vector(10, 6);
    samples.y = (gaussian_units(samples.x, found->centres, widths) * weights).array() + 0.25;
    const HyperParameters parameters = {{"centres", 10}, {"width factor", factor}, {"lambda", 1e-14}};
    const auto fit = fit_radial_basis(samples.set(), parameters, {.seed = 1});
    ASSERT_TRUE(fit);
    EXPECT_LT((evaluate_function(fit->function, samples.x) - samples.y).cwiseAbs().maxCoeff(), 1e-6) << factor;
    EXPECT_NEAR(fit->effective_parameters, 11, 1e-3);
  }
}

/// The widest units extrapolate a plane with the lowest error.
TEST(RadialBasisNetwork, ChoosesWideUnitsForPlane) {
  data::Samples samples{data::normal_matrix(200, 3, 7), {}, data::letters(3)};
  samples.y = samples.x.col(0) - 0.5 * samples.x.col(2) + 0.01 * data::normal_vector(200, 8);
  const auto choice = choose_radial_basis(folds_of(samples, 4), {}, {});
  ASSERT_TRUE(choice);
  EXPECT_GE(parameter_value(choice->parameters, "width factor"), 4);
}

TEST(RadialBasisNetwork, ChoosesOnlyCentresAllowedByFolds) {
  // Each fold has 27 training samples, which are too few for 40 or 80 centres.
  const data::Samples samples = data::bent_samples(36, 2, 0.05, 3);
  const auto choice = choose_radial_basis(folds_of(samples, 4), {}, {});
  ASSERT_TRUE(choice);
  EXPECT_LE(parameter_value(choice->parameters, "centres"), 20);
}

TEST(KohonenNetwork, ExplainsTargetToTolerance) {
  const data::Samples samples = data::bent_samples(300, 2, 0.02, 4);
  for (const double tolerance : {0.1, 0.01}) {
    const auto fit = fit_kohonen(samples.set(), {{"width factor", 4}, {"tolerance", tolerance}}, {});
    ASSERT_TRUE(fit);
    const Eigen::VectorXd residual = samples.y - evaluate_function(fit->function, samples.x);
    EXPECT_LT(residual.squaredNorm(), tolerance * (samples.y.array() - samples.y.mean()).square().sum());
    EXPECT_EQ(fit->effective_parameters,
              static_cast<double>(std::get<ExpansionModel>(fit->function).weights.size() + 1));
  }
}

}  // namespace
}  // namespace gyrotherm::methods
