// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/bias_tracker.hpp"

#include <gtest/gtest.h>

#include "analysis/tracking/assessment.hpp"
#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

/// Returns rates with single missing values and a gap of one hour.
Eigen::VectorXd rates_with_an_hours_gap(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd rates = draw(virtual_space(), 150, random).measured_deg_per_h;
  rates(0) = rates(17) = kMissing;
  rates.segment(60, 36).setConstant(kMissing);
  return rates;
}

TEST(BiasTracker, MatchesConditionalDistributionOfBias) {
  const StateSpace space = virtual_space();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Eigen::VectorXd rates = rates_with_an_hours_gap(seed);
    BiasTracker tracker(space);
    for (Eigen::Index k = 0; k < rates.size(); ++k) {
      tracker.push(rates(k));
      if (k % 13 != 0) continue;
      const Posterior expected = posterior(space, Eigen::VectorXd::Unit(k + 1, k), rates.head(k + 1));
      EXPECT_NEAR(tracker.estimate().deg_per_h, expected.mean, 1e-12) << seed << ", " << k;
      EXPECT_NEAR(tracker.estimate().std_deg_per_h, expected.std, 1e-12) << seed << ", " << k;
    }
  }
}

TEST(BiasTracker, MatchesConditionalDistributionOfNextHour) {
  const StateSpace space = virtual_space();
  const Eigen::VectorXd rates = rates_with_an_hours_gap(4);
  BiasTracker tracker(space);
  for (Eigen::Index k = 0; k < rates.size(); ++k) {
    tracker.push(rates(k));
    if (k % 29 != 0) continue;
    for (const int intervals : {1, 36}) {
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(k + 1 + intervals);
      weights.tail(intervals).setConstant(1.0 / intervals);
      const Posterior expected = posterior(space, weights, rates.head(k + 1));
      EXPECT_NEAR(tracker.forecast(intervals).deg_per_h, expected.mean, 1e-12) << k;
      EXPECT_NEAR(tracker.forecast(intervals).std_deg_per_h, expected.std, 1e-12) << k;
    }
  }
}

TEST(BiasTracker, GrowsUncertaintyDuringGap) {
  const StateSpace space = virtual_space();
  BiasTracker tracker(space);
  for (int k = 0; k < 500; ++k) tracker.push(0.001);
  const Estimate before = tracker.estimate();
  for (int k = 0; k < 36 * 24; ++k) tracker.push(kMissing);
  EXPECT_GT(tracker.estimate().std_deg_per_h, before.std_deg_per_h);
  EXPECT_LT(std::abs(tracker.estimate().deg_per_h), before.deg_per_h) << "Markov processes decay";
  EXPECT_TRUE(std::isfinite(tracker.estimate().deg_per_h));
}

TEST(BiasTracker, HasWhiteInnovationsOfExpectedVariance) {
  int large = 0, coloured = 0;
  constexpr int kSeeds = 200;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937_64 random(seed);
    const auto intervals = track(virtual_space(), draw(virtual_space(), 800, random).measured_deg_per_h);
    const Consistency consistency = test_consistency(intervals);
    large += consistency.mean_square < consistency.low || consistency.mean_square > consistency.high ? 1 : 0;
    coloured += consistency.whiteness.probability < 0.05 ? 1 : 0;
  }
  // The expected number is 5 % of 200: 10 ± 3.1.
  EXPECT_GT(large, 0);
  EXPECT_LT(large, 23);
  EXPECT_GT(coloured, 0);
  EXPECT_LT(coloured, 23);
}

TEST(BiasTracker, CoversTruthAsOftenAsStated) {
  int inside = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const DrawnBias known = known_bias(1000, seed);
    BiasTracker tracker(virtual_space());
    for (Eigen::Index k = 0; k + 36 < 1000; ++k) {
      tracker.push(known.measured_deg_per_h(k));
      if (k % 180 != 179) continue;
      const Estimate hour = tracker.forecast(36);
      const double error = known.bias_deg_per_h.segment(k + 1, 36).mean() - hour.deg_per_h;
      inside += std::abs(error) < 1.96 * hour.std_deg_per_h ? 1 : 0;
      ++count;
    }
  }
  EXPECT_NEAR(static_cast<double>(inside) / count, 0.95, 0.04) << "of " << count;
}

/// Returns the time in s that a settled tracker needs to reach half of a step of 1 °/h.
double half_step_time_s(const BiasNoise& noise) {
  BiasTracker tracker(state_space(noise, kInterval_s));
  for (int k = 0; k < 2000; ++k) tracker.push(0);
  for (int k = 1; k < 2000; ++k) {
    tracker.push(1);
    if (tracker.estimate().deg_per_h >= 0.5) return k * kInterval_s;
  }
  return kMissing;
}

TEST(BiasTracker, ReachesHalfOfStepWithinAnHour) {
  EXPECT_GT(half_step_time_s(virtual_noise()), 0.5 * 3600);
  EXPECT_LT(half_step_time_s(virtual_noise()), 1 * 3600);
}

TEST(BiasTracker, FollowsStepAtRateOfGain) {
  BiasNoise noise = virtual_noise();
  noise.instability_deg_per_h = 0;
  noise.rate_random_walk_deg_per_h_per_sqrt_h = 3e-4;
  const double gain = steady_state(state_space(noise, kInterval_s)).gain(0);
  EXPECT_NEAR(half_step_time_s(noise) / kInterval_s, std::log(0.5) / std::log(1 - gain), 1);
}

TEST(BiasTracker, LagsRampBySlopeOverGain) {
  BiasNoise noise = virtual_noise();
  noise.instability_deg_per_h = 0;
  noise.rate_random_walk_deg_per_h_per_sqrt_h = 1e-3;
  const StateSpace space = state_space(noise, kInterval_s);
  const double gain = steady_state(space).gain(0), slope = 1e-4;
  BiasTracker tracker(space);
  for (int k = 0; k <= 5000; ++k) tracker.push(slope * k);
  EXPECT_NEAR(5000 * slope - tracker.estimate().deg_per_h, slope * (1 - gain) / gain, 1e-9);
}

TEST(BiasTracker, ReturnsMeanForConstantBias) {
  const BiasNoise noise{.angle_random_walk_deg_per_sqrt_h = 3e-4, .start_deg_per_h = 10};
  std::mt19937_64 random(5);
  const Eigen::VectorXd rates = data::simulate({.N = 3e-4}, 300, kInterval_s, random);
  BiasTracker tracker(state_space(noise, kInterval_s));
  for (const double rate : rates) tracker.push(rate);
  EXPECT_NEAR(tracker.estimate().deg_per_h, rates.mean(), 1e-9);
  EXPECT_NEAR(tracker.estimate().std_deg_per_h, 1.8e-3 / std::sqrt(300), 1e-9);
}

TEST(BiasTracker, DoesNotDependOnInterval) {
  BiasNoise noise = virtual_noise();
  // The Markov processes of flicker would depend on the interval.
  noise.instability_deg_per_h = 0;
  std::mt19937_64 random(6);
  const Eigen::VectorXd seconds = draw(state_space(noise, 10), 20000, random).measured_deg_per_h;
  BiasTracker fine(state_space(noise, 10)), coarse(state_space(noise, 100));
  for (Eigen::Index k = 0; k < seconds.size(); k += 10) {
    for (Eigen::Index i = 0; i < 10; ++i) fine.push(seconds(k + i));
    coarse.push(seconds.segment(k, 10).mean());
  }
  EXPECT_NEAR(fine.estimate().deg_per_h, coarse.estimate().deg_per_h, 1e-3 * fine.estimate().std_deg_per_h + 1e-7);
  EXPECT_NEAR(fine.estimate().std_deg_per_h, coarse.estimate().std_deg_per_h, 0.01 * fine.estimate().std_deg_per_h);
}

constexpr int kRows = 100;

TEST(RestTracker, ReturnsTrackerOfPreviousIntervals) {
  const Eigen::VectorXd means = known_bias(50, 1).measured_deg_per_h;
  RestTracker rest(virtual_space(), kRows);
  BiasTracker tracker(virtual_space());
  for (Eigen::Index k = 0; k < means.size(); ++k) {
    const Estimate expected = k == 0 ? tracker.estimate() : tracker.forecast(1);
    for (int row = 0; row < kRows; ++row) {
      const double about = row % 2 == 0 ? 1 : -1;
      const Estimate bias = rest.push(means(k) + about, true);
      EXPECT_NEAR(bias.deg_per_h, expected.deg_per_h, 1e-15) << k << ", " << row;
      EXPECT_EQ(bias.std_deg_per_h, expected.std_deg_per_h);
    }
    tracker.push(means(k));
  }
}

TEST(RestTracker, IgnoresRatesWhileGyroMoves) {
  RestTracker rest(virtual_space(), kRows), still(virtual_space(), kRows);
  for (int row = 0; row < 100 * kRows; ++row) {
    const bool moves = row >= 40 * kRows + 37 && row < 60 * kRows + 2;
    const double rotation = moves ? 15000 : 0;
    const double returned = rest.push(0.001 + rotation, !moves).deg_per_h;
    EXPECT_LE(returned, 0.0011) << row;
    still.push(moves ? kMissing : 0.001, true);
  }
  EXPECT_EQ(rest.tracker().estimate().deg_per_h, still.tracker().estimate().deg_per_h);
  EXPECT_GT(rest.tracker().estimate().deg_per_h, 0.0008);
}

TEST(RestTracker, SkipsIntervalWithUnknownRow) {
  RestTracker rest(virtual_space(), kRows);
  for (int row = 0; row < kRows; ++row) EXPECT_EQ(rest.push(row == 50 ? kMissing : 1.0, true).deg_per_h, 0);
  EXPECT_EQ(rest.push(1, true).deg_per_h, 0);
  for (int row = 0; row < kRows; ++row) rest.push(1, true);
  EXPECT_GT(rest.push(1, true).deg_per_h, 0);
}

TEST(RestTracker, TreatsMissingRowsAsUnknown) {
  for (const int missing : {1, 60, 99, 100, 101, 350, 1000}) {
    RestTracker passing(virtual_space(), kRows), pushing(virtual_space(), kRows);
    for (RestTracker* tracker : {&passing, &pushing})
      for (int row = 0; row < 940; ++row) tracker->push(1, true);
    passing.skip_rows(missing);
    for (int row = 0; row < missing; ++row) pushing.push(kMissing, true);
    for (int row = 0; row < 250; ++row) {
      const Estimate passed = passing.push(1, true), pushed = pushing.push(1, true);
      EXPECT_EQ(passed.deg_per_h, pushed.deg_per_h) << missing << ", " << row;
      EXPECT_EQ(passed.std_deg_per_h, pushed.std_deg_per_h) << missing << ", " << row;
    }
  }
}

}  // namespace
}  // namespace gyrotherm::tracking
