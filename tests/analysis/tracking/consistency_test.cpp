// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/consistency.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

TEST(Whiteness, OfWhiteValuesIsUniform) {
  std::vector<double> probabilities;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Eigen::VectorXd values = white_noise(600, seed);
    values.segment(100, 40).setConstant(kMissing);
    probabilities.push_back(whiteness_of(values, 20).probability);
  }
  std::ranges::sort(probabilities);
  double farthest = 0;  // Kolmogorov and Smirnov
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    farthest = std::max(farthest, std::abs(probabilities[i] - (static_cast<double>(i) + 0.5) / 400));
  }
  EXPECT_LT(farthest, 1.63 / std::sqrt(400)) << "1 %";
}

TEST(Whiteness, FindsAWeakCorrelation) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Eigen::VectorXd values = white_noise(1440, seed);
    for (Eigen::Index k = 1; k < values.size(); ++k) values(k) += 0.2 * values(k - 1);
    found += whiteness_of(values, 20).probability < 0.01 ? 1 : 0;
  }
  EXPECT_EQ(found, 50);
}

TEST(Whiteness, OfTooFewIsNotKnown) {
  EXPECT_TRUE(std::isnan(whiteness_of(white_noise(40, 1), 20).probability));
  EXPECT_TRUE(std::isnan(whiteness_of(Eigen::VectorXd::Zero(100), 20).probability));
}

TEST(Whiteness, IsTheSameOfValuesOfAnySize) {
  Eigen::VectorXd values = white_noise(200, 1);
  values(7) = kMissing;
  const Whiteness expected = whiteness_of(values, 20);
  for (const int exponent : {1000, 500, -500, -900}) {
    const Whiteness found = whiteness_of(values * std::exp2(exponent), 20);
    EXPECT_EQ(found.statistic, expected.statistic) << exponent;
    EXPECT_EQ(found.probability, expected.probability) << exponent;
  }
  EXPECT_LT(whiteness_of(Eigen::VectorXd::Constant(200, -1e308), 20).probability, 1e-6);
}

TEST(Consistency, SeesANoiseThatIsNotTheOneThatWasTold) {
  const Eigen::VectorXd rates = known_bias(1440, 1).measured_deg_per_h;
  BiasNoise quiet = virtual_noise(), lazy = virtual_noise();
  quiet.angle_random_walk_deg_per_sqrt_h /= 1.1;
  lazy.instability_deg_per_h = lazy.rate_random_walk_deg_per_h_per_sqrt_h = 0;
  const auto judged = [&](const BiasNoise& noise) {
    return consistency_of(track(state_space(noise, kInterval_s), rates), 72);
  };
  EXPECT_GT(judged(quiet).mean_square, judged(quiet).high);
  const Consistency right = judged(virtual_noise());
  EXPECT_GT(right.mean_square, right.low);
  EXPECT_LT(right.mean_square, right.high);
  EXPECT_GT(right.whiteness.probability, 0.05);
  EXPECT_GT(judged(lazy).whiteness.statistic, right.whiteness.statistic);
  EXPECT_EQ(right.innovations, 1440 - 72);
}

}  // namespace
}  // namespace gyrotherm::tracking
