// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/bias_noise.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

constexpr double kNoFloor = std::numeric_limits<double>::quiet_NaN();

data::Clusters spaced_clusters(Eigen::Index count) {
  data::Clusters clusters;
  clusters.start_s = Eigen::VectorXd::LinSpaced(count, 0, kInterval_s * static_cast<double>(count - 1));
  return clusters;
}

TEST(BiasNoise, RecoversNoiseOfResidual) {
  BiasNoise made = virtual_noise();
  made.instability_deg_per_h = 1e-3;
  made.rate_random_walk_deg_per_h_per_sqrt_h = 0;
  made.start_deg_per_h = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto noise =
        estimate_bias_noise(known_bias(4000, seed, made).measured_deg_per_h, spaced_clusters(4000), kNoFloor);
    ASSERT_TRUE(noise) << text(noise.error());
    EXPECT_NEAR(noise->angle_random_walk_deg_per_sqrt_h, 3e-4, 0.15 * 3e-4) << seed;
    // A tracker cannot distinguish flicker of this size from a random walk with the same Allan deviation at the
    // relevant times.
    const double wander =
        std::hypot(0.664 * noise->instability_deg_per_h, noise->rate_random_walk_deg_per_h_per_sqrt_h / std::sqrt(3));
    EXPECT_NEAR(wander, 0.664e-3, 0.25e-3) << seed;
  }
}

TEST(BiasNoise, UsesRmsOfResidualAsInitialUncertainty) {
  Eigen::VectorXd residual = known_bias(1000, 1).measured_deg_per_h;
  residual(500) = kMissing;
  const auto noise = estimate_bias_noise(residual, spaced_clusters(1000), kNoFloor);
  ASSERT_TRUE(noise);
  const double squares = residual.head(500).squaredNorm() + residual.tail(499).squaredNorm();
  EXPECT_NEAR(noise->start_deg_per_h, std::sqrt(squares / 999), 1e-15);
}

TEST(BiasNoise, FailsForShortResidual) {
  const auto noise = estimate_bias_noise(known_bias(30, 1).measured_deg_per_h, spaced_clusters(30), kNoFloor);
  ASSERT_FALSE(noise);
  EXPECT_EQ(noise.error().kind, FaultKind::usage);
  EXPECT_NE(noise.error().what.find("30 means"), std::string::npos) << noise.error().what;
}

TEST(BiasNoise, FailsWithoutWhiteNoise) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(1000, 0, 1);
  const auto noise = estimate_bias_noise(line, spaced_clusters(1000), kNoFloor);
  ASSERT_FALSE(noise);
  EXPECT_NE(noise.error().what.find("no angle random walk"), std::string::npos) << noise.error().what;
}

/// Model errors may hide the white noise of the residual. The noise floor of the record still reveals it.
TEST(BiasNoise, UsesNoiseFloorWhenResidualHidesWhiteNoise) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(1000, 0, 1);
  const auto noise = estimate_bias_noise(line, spaced_clusters(1000), 0.0018);
  ASSERT_TRUE(noise) << text(noise.error());
  EXPECT_NEAR(noise->angle_random_walk_deg_per_sqrt_h, 3e-4, 1e-12) << "equals 0.0018 °/h over 100 s";
}

}  // namespace
}  // namespace gyrotherm::tracking
