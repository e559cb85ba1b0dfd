// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/learnt_limit.hpp"

#include "analysis/fusion/change_detector.hpp"
#include "analysis/fusion/run_length.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

constexpr double kSlack = 0.5;

/// White vectors, a column each, whose variance is 1.5 in every third run of ten steps: a ramp.
Eigen::MatrixXd noisier_in_ramps(int dimension, Eigen::Index count, Draws& draws) {
  constexpr Eigen::Index kLasts = 10, kEvery = 3;
  Eigen::MatrixXd vectors(dimension, count);
  for (Eigen::Index k = 0; k < count; ++k)
    vectors.col(k) = std::sqrt(k / kLasts % kEvery == 0 ? 1.5 : 1.0) * draws.normal(dimension);
  return vectors;
}

/// White vectors of variance 0.95 with a mean of variance 0.05 that lasts for 15 steps. Their variance is 1.
Eigen::MatrixXd with_lasting_errors(int dimension, Eigen::Index count, Draws& draws) {
  constexpr Eigen::Index kLasts = 15;
  constexpr double kOfMean = 0.05;
  Eigen::MatrixXd vectors(dimension, count);
  Eigen::VectorXd mean;
  for (Eigen::Index k = 0; k < count; ++k) {
    if (k % kLasts == 0) mean = std::sqrt(kOfMean) * draws.normal(dimension);
    vectors.col(k) = mean + std::sqrt(1 - kOfMean) * draws.normal(dimension);
  }
  return vectors;
}

Eigen::MatrixXd louder(int dimension, Eigen::Index count, Draws& draws) {
  Eigen::MatrixXd vectors(dimension, count);
  for (Eigen::Index k = 0; k < count; ++k) vectors.col(k) = 1.2 * draws.normal(dimension);
  return vectors;
}

/// Returns the steps per alarm in other vectors of the same kind.
double run_length(auto kind, int dimension, double limit, Eigen::Index count) {
  int alarms = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(100 + seed));
    const Eigen::MatrixXd vectors = kind(dimension, count, draws);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(dimension);
    for (Eigen::Index k = 0; k < count; ++k) {
      if (add_less_slack(sum, vectors.col(k), kSlack) - kSlack <= limit) continue;
      ++alarms;
      sum.setZero();
    }
  }
  return static_cast<double>(kSeeds * count) / alarms;
}

/// A limit that is learnt from 8000 vectors makes a rate that scatters by some 15 %. The mean over ten healthy records
/// must meet the stated one.
void expect_meets_where_white_does_not(auto kind) {
  constexpr double kStated = 500, kTolerance = 0.3;
  constexpr Eigen::Index kLearnt = 8000, kOthers = 10000;
  constexpr int kRecords = 10;
  for (const int dimension : {1, 4}) {
    double rates = 0;
    for (int record = 1; record <= kRecords; ++record) {
      Draws draws(static_cast<std::uint64_t>(record));
      const auto limit = limit_of_healthy(kind(dimension, kLearnt, draws), kSlack, kStated);
      ASSERT_TRUE(limit);
      rates += kStated / run_length(kind, dimension, *limit, kOthers);
    }
    EXPECT_NEAR(rates / kRecords, 1, kTolerance) << dimension;
    const double white = limit_for_run_length(dimension, kSlack, kStated);
    EXPECT_GT(kStated / run_length(kind, dimension, white, kOthers), 1 + kTolerance) << dimension;
  }
}

TEST(LearntLimit, MeetsTheStatedRateWhereRampsAreNoisier) { expect_meets_where_white_does_not(noisier_in_ramps); }

TEST(LearntLimit, MeetsTheStatedRateWhereErrorsLast) { expect_meets_where_white_does_not(with_lasting_errors); }

/// The run is 2.5 times as long as the record that is learnt from. Some 400 alarms are expected in the others.
TEST(LearntLimit, MeetsARateThatTheRecordIsTooShortFor) {
  constexpr double kStated = 20000;
  Draws draws(1);
  const auto limit = limit_of_healthy(louder(2, 8000, draws), kSlack, kStated);
  ASSERT_TRUE(limit);
  EXPECT_NEAR(kStated / run_length(louder, 2, *limit, 400000), 1, 0.3);
  EXPECT_GT(kStated / run_length(louder, 2, limit_for_run_length(2, kSlack, kStated), 20000), 3);
}

TEST(LearntLimit, IsNeverBelowThatOfWhiteVectors) {
  Draws draws(1);
  const Eigen::MatrixXd quiet = 0.5 * louder(3, 1000, draws);
  for (const double stated : {500.0, 36000.0})
    EXPECT_EQ(*limit_of_healthy(quiet, kSlack, stated), limit_for_run_length(3, kSlack, stated));
}

TEST(LearntLimit, IsNotLearntOfAFewVectors) {
  Draws draws(1);
  const Eigen::MatrixXd vectors = louder(2, kFewestHealthy, draws);
  EXPECT_TRUE(limit_of_healthy(vectors, kSlack, 500));
  EXPECT_FALSE(limit_of_healthy(vectors.leftCols(kFewestHealthy - 1), kSlack, 500));
}

TEST(ChangeDetector, AlarmsAboveTheLimitThatItIsGiven) {
  const auto made = ChangeDetector::make({.dimension = 1, .shift = 1, .false_alarms_per_h = 1, .interval_s = 100});
  ASSERT_TRUE(made);
  ChangeDetector higher = made->with_limit(10);
  EXPECT_EQ(higher.limit(), 10);
  int steps = 1;
  while (!higher.push(Eigen::VectorXd::Constant(1, 2))) ++steps;
  EXPECT_EQ(steps, 7) << "each adds 2 less the slack of 0.5: 10.5 is the first sum above 10";
}

}  // namespace
}  // namespace gyrotherm::fusion
