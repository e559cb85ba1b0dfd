// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/change_detector.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/fusion/rate_fusion.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

/// Returns the mean number of steps to an alarm in simulated runs. Run lengths are nearly exponentially distributed, so
/// the standard error is the mean divided by √runs.
double simulated_run_length(int dimension, double slack, double limit, int runs) {
  double steps = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int run = 0; run < runs / kSeeds; ++run) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(dimension);
      while (sum.norm() <= limit) {
        sum += draws.normal(dimension);
        sum *= std::max(0.0, 1 - slack / sum.norm());
        ++steps;
      }
    }
  }
  return steps / runs;
}

TEST(RunLength, MatchesSimulation) {
  constexpr int kRuns = 4000;
  struct Chart {
    int dimension;
    double slack, limit;
  };
  for (const Chart& chart : {Chart{1, 0.5, 4}, {2, 0.5, 5.5}, {3, 0.2, 12}, {10, 0.5, 15}}) {
    const double expected = average_run_length(chart.dimension, chart.slack, chart.limit);
    EXPECT_NEAR(simulated_run_length(chart.dimension, chart.slack, chart.limit, kRuns) / expected, 1,
                4 / std::sqrt(kRuns))
        << chart.dimension;
  }
}

/// Markov chain approximation of Brook and Evans, Biometrika 59 (1972) 539: −h … h is divided into small intervals.
/// The transition probabilities come from the normal distribution; the noncentral χ² is not used.
TEST(RunLength, MatchesFineMarkovChainInOneDimension) {
  const double slack = 0.25, limit = 6;
  // The middle state is exactly 0, which the slack produces.
  constexpr int kHalf = 300, kStates = 2 * kHalf + 1;
  const double width = limit / kHalf;
  const auto below = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  Eigen::VectorXd centres = Eigen::VectorXd::Zero(kStates);
  for (int i = 1; i <= kHalf; ++i) {
    centres(kHalf + i) = (i - 0.5) * width;
    centres(kHalf - i) = -centres(kHalf + i);
  }
  Eigen::MatrixXd left = Eigen::MatrixXd::Identity(kStates, kStates);
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < kStates; ++j) {
      const double middle = j == kHalf ? 0 : centres(j) + std::copysign(slack, centres(j));
      const double half = j == kHalf ? slack : width / 2;
      left(i, j) -= below(middle + half - centres(i)) - below(middle - half - centres(i));
    }
  }
  const Eigen::VectorXd lengths = left.partialPivLu().solve(Eigen::VectorXd::Ones(kStates));
  EXPECT_NEAR(average_run_length(1, slack, limit) / lengths(kHalf), 1, 1e-3);
}

TEST(RunLength, IsReachedByItsLimit) {
  for (const int dimension : {1, 3, 8}) {
    for (const double slack : {0.1, 0.5}) {
      double before = 0;
      for (const double run_length : {50.0, 3600.0, 1e6}) {
        const double limit = limit_for_run_length(dimension, slack, run_length);
        EXPECT_GT(limit, before);
        EXPECT_NEAR(average_run_length(dimension, slack, limit) / run_length, 1, 1e-4) << dimension << ", " << slack;
        before = limit;
      }
    }
  }
}

/// For one dimension and long runs, increasing h by 1 multiplies the run length by exp(2k), because exp(2 k S) is
/// Wald's martingale.
TEST(RunLength, GrowsExponentiallyWithTwiceTheSlack) {
  const double slack = 0.2, first = average_run_length(1, slack, 25), second = average_run_length(1, slack, 26);
  EXPECT_NEAR(std::log(second / first), 2 * slack, 1e-3);
}

constexpr double kSlack = 0.5;

/// Draws white vectors as columns. Their variance is 1.5 in every third period of ten steps, as in ramps, otherwise 1.
Eigen::MatrixXd vectors_noisier_in_ramps(int dimension, Eigen::Index count, Draws& draws) {
  constexpr Eigen::Index kPeriod = 10, kEvery = 3;  // steps, periods
  Eigen::MatrixXd vectors(dimension, count);
  for (Eigen::Index k = 0; k < count; ++k)
    vectors.col(k) = std::sqrt(k / kPeriod % kEvery == 0 ? 1.5 : 1.0) * draws.normal(dimension);
  return vectors;
}

/// Draws white vectors of variance 0.95 plus a mean of variance 0.05 that changes every 15 steps. The total variance is
/// 1.
Eigen::MatrixXd vectors_with_persistent_errors(int dimension, Eigen::Index count, Draws& draws) {
  constexpr Eigen::Index kPeriod = 15;
  constexpr double kMeanVariance = 0.05;
  Eigen::MatrixXd vectors(dimension, count);
  Eigen::VectorXd mean;
  for (Eigen::Index k = 0; k < count; ++k) {
    if (k % kPeriod == 0) mean = std::sqrt(kMeanVariance) * draws.normal(dimension);
    vectors.col(k) = mean + std::sqrt(1 - kMeanVariance) * draws.normal(dimension);
  }
  return vectors;
}

/// Draws white vectors with a standard deviation of 1.2 in each component.
Eigen::MatrixXd vectors_with_more_noise(int dimension, Eigen::Index count, Draws& draws) {
  Eigen::MatrixXd vectors(dimension, count);
  for (Eigen::Index k = 0; k < count; ++k) vectors.col(k) = 1.2 * draws.normal(dimension);
  return vectors;
}

/// Draws vectors with independent components, each an autoregressive process of variance 1 with a correlation of 0.8
/// from step to step.
Eigen::MatrixXd strongly_correlated_vectors(int dimension, Eigen::Index count, Draws& draws) {
  constexpr double kCorrelation = 0.8;
  Eigen::MatrixXd vectors(dimension, count);
  Eigen::VectorXd value = draws.normal(dimension);
  for (Eigen::Index k = 0; k < count; ++k) {
    vectors.col(k) = value;
    value = kCorrelation * value + std::sqrt(1 - kCorrelation * kCorrelation) * draws.normal(dimension);
  }
  return vectors;
}

/// Returns the mean number of steps per alarm in `count` vectors of `draw` for each seed.
double steps_per_alarm(auto draw, int dimension, double limit, Eigen::Index count) {
  int alarms = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(100 + seed));
    const Eigen::MatrixXd vectors = draw(dimension, count, draws);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(dimension);
    for (Eigen::Index k = 0; k < count; ++k) {
      if (add_less_slack(sum, vectors.col(k), kSlack) - kSlack <= limit) continue;
      ++alarms;
      sum.setZero();
    }
  }
  return static_cast<double>(kSeeds * count) / alarms;
}

/// Requires that a learnt limit has the stated false alarm rate, and that the limit for white vectors exceeds it. A
/// limit learnt from 8000 vectors gives a rate that scatters by about 15 %, so the mean of ten limits is compared.
void expect_stated_rate_only_when_learnt(auto draw) {
  constexpr double kStated = 500, kTolerance = 0.3;
  constexpr Eigen::Index kLearnt = 8000, kOthers = 10000;
  constexpr int kRecords = 10;
  for (const int dimension : {1, 4}) {
    double rates = 0;
    for (int record = 1; record <= kRecords; ++record) {
      Draws draws(static_cast<std::uint64_t>(record));
      const auto limit = learn_sum_limit(draw(dimension, kLearnt, draws), kSlack, kStated);
      ASSERT_TRUE(limit);
      rates += kStated / steps_per_alarm(draw, dimension, *limit, kOthers);
    }
    EXPECT_NEAR(rates / kRecords, 1, kTolerance) << dimension;
    const double white = limit_for_run_length(dimension, kSlack, kStated);
    EXPECT_GT(kStated / steps_per_alarm(draw, dimension, white, kOthers), 1 + kTolerance) << dimension;
  }
}

TEST(LearntLimit, MeetsStatedRateWhenRampsAreNoisier) { expect_stated_rate_only_when_learnt(vectors_noisier_in_ramps); }

TEST(LearntLimit, MeetsStatedRateWhenErrorsPersist) {
  expect_stated_rate_only_when_learnt(vectors_with_persistent_errors);
}

/// The stated run length is 2.5 times the length of the healthy record. About 400 alarms are expected in the simulated
/// records.
TEST(LearntLimit, MeetsStatedRateWhenRecordIsShorterThanRunLength) {
  constexpr double kStated = 20000;
  Draws draws(1);
  const auto limit = learn_sum_limit(vectors_with_more_noise(2, 8000, draws), kSlack, kStated);
  ASSERT_TRUE(limit);
  EXPECT_NEAR(kStated / steps_per_alarm(vectors_with_more_noise, 2, *limit, 400000), 1, 0.3);
  EXPECT_GT(kStated / steps_per_alarm(vectors_with_more_noise, 2, limit_for_run_length(2, kSlack, kStated), 20000), 3);
}

/// The variance of a mean is about nine times that of white vectors, so the limit is far above theirs.
TEST(LearntLimit, MeetsStatedRateWhenCorrelationIsStrong) {
  constexpr double kStated = 500;
  for (const int dimension : {1, 3}) {
    Draws draws(1);
    const auto limit = learn_sum_limit(strongly_correlated_vectors(dimension, 8000, draws), kSlack, kStated);
    ASSERT_TRUE(limit) << dimension;
    EXPECT_GT(*limit, 4 * limit_for_run_length(dimension, kSlack, kStated));
    const double rate = kStated / steps_per_alarm(strongly_correlated_vectors, dimension, *limit, 20000);
    EXPECT_NEAR(rate, 1, 0.5) << dimension;
  }
}

TEST(LearntLimit, MeetsStatedRateWhenCorrelationIsStrongAndRecordIsShort) {
  constexpr double kStated = 2000;
  Draws draws(2);
  const auto limit = learn_sum_limit(strongly_correlated_vectors(1, 1000, draws), kSlack, kStated);
  ASSERT_TRUE(limit);
  EXPECT_NEAR(std::log(steps_per_alarm(strongly_correlated_vectors, 1, *limit, 40000) / kStated), 0, std::log(3));
}

TEST(LearntLimit, IsMissingWhenNoLimitHasStatedRate) {
  Draws draws(1);
  Eigen::MatrixXd walk = vectors_with_more_noise(2, 2000, draws);
  for (Eigen::Index k = 1; k < walk.cols(); ++k) walk.col(k) += walk.col(k - 1);
  EXPECT_FALSE(learn_sum_limit(walk, kSlack, 500)) << "a random walk";
  const Eigen::MatrixXd offset = vectors_with_more_noise(1, 2000, draws).array() + 2;
  EXPECT_FALSE(learn_sum_limit(offset, kSlack, 500)) << "a mean above the slack";
  EXPECT_FALSE(learn_sum_limit(offset.leftCols(500), kSlack, 36000)) << "also for a short record";
}

TEST(LearntLimit, IsNeverBelowLimitForWhiteVectors) {
  Draws draws(1);
  const Eigen::MatrixXd quiet = 0.5 * vectors_with_more_noise(3, 1000, draws);
  for (const double stated : {500.0, 36000.0})
    EXPECT_EQ(*learn_sum_limit(quiet, kSlack, stated), limit_for_run_length(3, kSlack, stated));
}

TEST(LearntLimit, IsMissingForTooFewVectors) {
  Draws draws(1);
  const Eigen::MatrixXd vectors = vectors_with_more_noise(2, kFewestHealthy, draws);
  EXPECT_TRUE(learn_sum_limit(vectors, kSlack, 500));
  EXPECT_FALSE(learn_sum_limit(vectors.leftCols(kFewestHealthy - 1), kSlack, 500));
}

TEST(ChangeDetector, AlarmsAboveGivenLimit) {
  const auto made = ChangeDetector::make({.dimension = 1, .shift = 1, .false_alarms_per_h = 1, .interval_s = 100});
  ASSERT_TRUE(made);
  ChangeDetector higher = made->with_limit(10);
  EXPECT_EQ(higher.limit(), 10);
  int steps = 1;
  while (!higher.push(Eigen::VectorXd::Constant(1, 2))) ++steps;
  EXPECT_EQ(steps, 7) << "each step adds 2 minus the slack of 0.5; the first sum above 10 is 10.5";
}

constexpr double kHop_deg_per_h = 0.01;
/// Noise of a one-second mean for an angle random walk of 3e-4 °/√h.
constexpr double kSecond_deg_per_h = 0.018;

ChangeDetector detector(int dimension, double shift, double false_alarms_per_h) {
  auto made = ChangeDetector::make(
      {.dimension = dimension, .shift = shift, .false_alarms_per_h = false_alarms_per_h, .interval_s = 1});
  EXPECT_TRUE(made) << text(made.error());
  return *made;
}

/// 20 seeds of ten hours each at six false alarms per hour: 1200 ± 35 alarms are expected. The tolerance is four
/// standard deviations, for each seed and in total.
TEST(ChangeDetector, HasStatedFalseAlarmRate) {
  constexpr double kPerHour = 6, kHours = 10;
  for (const int dimension : {1, 3}) {
    int alarms = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      Draws draws(static_cast<std::uint64_t>(seed));
      ChangeDetector changes = detector(dimension, 0.4, kPerHour);
      int alarms_of_seed = 0;
      for (int second = 0; second < static_cast<int>(kHours * 3600); ++second)
        alarms_of_seed += changes.push(draws.normal(dimension)) ? 1 : 0;
      EXPECT_NEAR(alarms_of_seed, kPerHour * kHours, 4 * std::sqrt(kPerHour * kHours)) << "seed " << seed;
      alarms += alarms_of_seed;
    }
    const double expected = kPerHour * kHours * kSeeds;
    EXPECT_NEAR(alarms, expected, 4 * std::sqrt(expected)) << dimension;
  }
}

/// The parity of a dodecahedron contains √½ of a hop, which is 0.39 of the noise of one second. The limit for one false
/// alarm in a thousand hours is 44. The hop is detected and its axis identified within a few minutes.
TEST(ChangeDetector, FindsHopBelowNoiseOfOneSecond) {
  const Geometry geometry = valid_geometry(dodecahedron_axes(kSecond_deg_per_h));
  const Gains gains = compute_gains(geometry);
  const FaultTest test = parity_test(gains, geometry);
  const double shift = kHop_deg_per_h * test.effects.col(0).norm();
  double delays = 0;
  int named = 0;
  constexpr int kQuiet = 1800;
  const ChangeDetector fresh = detector(3, shift, 1e-3);
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    ChangeDetector changes = fresh;
    const Eigen::Index hopped = seed % 6;
    std::optional<Change> change;
    int second = 0;
    for (; !change && second < kQuiet + 3600; ++second) {
      Eigen::VectorXd readings =
          geometry.directions * Eigen::Vector3d(5, -8, 3) + draws.correlated_normal(geometry.covariance);
      if (second >= kQuiet) readings(hopped) += kHop_deg_per_h;
      change = changes.push(gains.parity * readings);
    }
    ASSERT_TRUE(change) << "seed " << seed;
    ASSERT_GT(second, kQuiet) << "seed " << seed << ": a false alarm";
    delays += second - kQuiet;
    const auto isolation = isolate(test, change->root_sum());
    ASSERT_TRUE(isolation);
    named += isolation->candidate == hopped ? 1 : 0;
    EXPECT_EQ(isolation->candidate.value_or(hopped), hopped) << "seed " << seed;
    const double root = std::sqrt(change->steps);
    EXPECT_NEAR(isolation->size / root, kHop_deg_per_h, 4 * isolation->size_std / root) << "seed " << seed;
  }
  const double expected = fresh.limit() / (shift - fresh.slack());
  EXPECT_NEAR(delays / kSeeds, expected, 0.3 * expected) << "approximate, because the sum is not 0 at the hop";
  EXPECT_LT(delays / kSeeds, 300);
  EXPECT_GE(named, 19);
}

TEST(ChangeDetector, IgnoresMissingValues) {
  ChangeDetector changes = detector(2, 1, 1);
  EXPECT_FALSE(changes.push(Eigen::Vector2d(2, 0)));
  const double level = changes.level();
  EXPECT_NEAR(level, 1.5, 1e-12);
  EXPECT_FALSE(changes.push(Eigen::Vector2d(std::numeric_limits<double>::quiet_NaN(), 0)));
  EXPECT_EQ(changes.level(), level);
  EXPECT_FALSE(changes.push(Eigen::Vector2d(-1.4, 0))) << "within the slack: the sum restarts at 0";
  EXPECT_EQ(changes.level(), 0);
}

TEST(ChangeDetector, ReportsMeanAndRestartsAfterAlarm) {
  ChangeDetector changes = detector(2, 1, 1);
  int steps = 0;
  std::optional<Change> change;
  while (!change) {
    ++steps;
    change = changes.push(Eigen::Vector2d(0, -2));
  }
  EXPECT_EQ(change->steps, steps);
  EXPECT_EQ(steps, std::floor(changes.limit() / 1.5) + 1);
  EXPECT_TRUE(change->mean.isApprox(Eigen::Vector2d(0, -2)));
  EXPECT_EQ(changes.level(), 0);
}

TEST(ChangeDetector, RejectsInvalidOptions) {
  const auto fails = [](const ChangeOptions& options) {
    const auto made = ChangeDetector::make(options);
    return !made && made.error().kind == FaultKind::usage;
  };
  EXPECT_TRUE(fails({.dimension = 0, .shift = 1, .false_alarms_per_h = 1}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 0, .false_alarms_per_h = 1}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 1, .false_alarms_per_h = 0}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 1, .false_alarms_per_h = 1000}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = 1, .false_alarms_per_h = 1e-9}));
  EXPECT_TRUE(fails({.dimension = 1, .shift = std::nan(""), .false_alarms_per_h = 1}));
}

}  // namespace
}  // namespace gyrotherm::fusion
