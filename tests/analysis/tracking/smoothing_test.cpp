// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/smoothing.hpp"

#include <gtest/gtest.h>

#include "analysis/tracking/bias_tracker.hpp"
#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

Eigen::VectorXd rates_with_gaps(Eigen::Index count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd rates = draw(virtual_space(), count, random).measured_deg_per_h;
  rates(0) = rates(count / 2) = kMissing;
  rates.segment(count / 3, count / 6).setConstant(kMissing);
  return rates;
}

TEST(Smoothing, MatchesConditionalDistributionGivenAllRates) {
  const StateSpace space = virtual_space();
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Eigen::VectorXd rates = rates_with_gaps(120, seed);
    const SmoothedBias smoothed = smooth(space, rates);
    for (Eigen::Index k = 0; k < rates.size(); k += 7) {
      const Posterior expected = posterior(space, Eigen::VectorXd::Unit(rates.size(), k), rates);
      EXPECT_NEAR(smoothed.deg_per_h(k), expected.mean, 1e-12) << seed << ", " << k;
      EXPECT_NEAR(smoothed.std_deg_per_h(k), expected.std, 1e-12) << seed << ", " << k;
    }
  }
}

TEST(Smoothing, MatchesRauchTungStriebel) {
  const StateSpace space = virtual_space();
  const Eigen::VectorXd rates = rates_with_gaps(90, 7);
  const SmoothedBias smoothed = smooth(space, rates);
  std::vector<State> states;
  std::vector<Covariance> covariances;
  BiasTracker tracker(space);
  for (const double rate : rates) {
    tracker.push(rate);
    states.push_back(tracker.state());
    covariances.push_back(tracker.covariance());
  }
  State state = states.back();
  Covariance covariance = covariances.back();
  const Covariance step = space.memory.asDiagonal();
  /// Implements equations (3.29) to (3.31) of Rauch, Tung and Striebel.
  for (std::size_t k = states.size() - 1; k-- > 0;) {
    Covariance predicted = step * covariances[k] * step;
    predicted.diagonal() += space.fresh;
    const Covariance gain = covariances[k] * step * predicted.inverse();
    state = (states[k] + gain * (state - step * states[k])).eval();
    covariance = (covariances[k] + gain * (covariance - predicted) * gain.transpose()).eval();
    EXPECT_NEAR(smoothed.deg_per_h(static_cast<Eigen::Index>(k)), state.sum(), 1e-11) << k;
    EXPECT_NEAR(smoothed.std_deg_per_h(static_cast<Eigen::Index>(k)), std::sqrt(covariance.sum()), 1e-10) << k;
  }
}

TEST(Smoothing, WithLagMatchesSmootherOfRatesSoFar) {
  const StateSpace space = virtual_space();
  const Eigen::VectorXd rates = rates_with_gaps(120, 4);
  for (const Eigen::Index lag : {0, 1, 36}) {
    const Eigen::VectorXd lagging = smooth_with_lag(space, rates, lag);
    for (Eigen::Index k = 0; k < rates.size(); ++k) {
      EXPECT_EQ(std::isnan(lagging(k)), k < lag);
      if (k >= lag && k % 11 == 0) {
        EXPECT_NEAR(lagging(k), smooth(space, rates.head(k + 1)).deg_per_h(k - lag), 1e-14) << lag << ", " << k;
      }
    }
  }
}

TEST(Smoothing, WithoutLagMatchesTracker) {
  const StateSpace space = virtual_space();
  const Eigen::VectorXd rates = rates_with_gaps(60, 5), at_once = smooth_with_lag(space, rates, 0);
  BiasTracker tracker(space);
  for (Eigen::Index k = 0; k < rates.size(); ++k) {
    tracker.push(rates(k));
    EXPECT_NEAR(at_once(k), tracker.estimate().deg_per_h, 1e-15);
  }
}

TEST(Smoothing, HasLowerErrorThanTracker) {
  double tracked = 0, smoothed = 0, stated = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    std::mt19937_64 random(seed);
    const DrawnBias known = draw(virtual_space(), 720, random);
    const SmoothedBias after = smooth(virtual_space(), known.measured_deg_per_h);
    BiasTracker tracker(virtual_space());
    for (Eigen::Index k = 0; k < 720; ++k) {
      tracker.push(known.measured_deg_per_h(k));
      tracked += std::pow(tracker.estimate().deg_per_h - known.bias_deg_per_h(k), 2);
      smoothed += std::pow(after.deg_per_h(k) - known.bias_deg_per_h(k), 2);
      stated += std::pow(after.std_deg_per_h(k), 2);
    }
  }
  EXPECT_LT(std::sqrt(smoothed), 0.85 * std::sqrt(tracked));
  EXPECT_NEAR(std::sqrt(smoothed / stated), 1, 0.15) << "the error agrees with the stated uncertainty";
}

}  // namespace
}  // namespace gyrotherm::tracking
