// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/rest_tracker.hpp"

#include <gtest/gtest.h>

#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

constexpr int kRows = 100;

TEST(RestTracker, IsTheTrackerOfItsMeansAnIntervalBefore) {
  const Eigen::VectorXd means = known_bias(50, 1).measured_deg_per_h;
  RestTracker rest(virtual_space(), kRows);
  BiasTracker tracker(virtual_space());
  for (Eigen::Index k = 0; k < means.size(); ++k) {
    const Estimate expected = k == 0 ? tracker.now() : tracker.forecast(1);
    for (int row = 0; row < kRows; ++row) {
      const double about = row % 2 == 0 ? 1 : -1;
      const Estimate bias = rest.push(means(k) + about, true);
      EXPECT_NEAR(bias.deg_per_h, expected.deg_per_h, 1e-15) << k << ", " << row;
      EXPECT_EQ(bias.std_deg_per_h, expected.std_deg_per_h);
    }
    tracker.push(means(k));
  }
}

TEST(RestTracker, LearnsNothingWhileTheGyroMoves) {
  RestTracker rest(virtual_space(), kRows), still(virtual_space(), kRows);
  for (int row = 0; row < 100 * kRows; ++row) {
    const bool moves = row >= 40 * kRows + 37 && row < 60 * kRows + 2;
    const double rotation = moves ? 15000 : 0;
    const double said = rest.push(0.001 + rotation, !moves).deg_per_h;
    EXPECT_LE(said, 0.0011) << row;
    still.push(moves ? kMissing : 0.001, true);
  }
  EXPECT_EQ(rest.tracker().now().deg_per_h, still.tracker().now().deg_per_h);
  EXPECT_GT(rest.tracker().now().deg_per_h, 0.0008);
}

TEST(RestTracker, PassesOverAnIntervalWithARowThatIsNotKnown) {
  RestTracker rest(virtual_space(), kRows);
  for (int row = 0; row < kRows; ++row) EXPECT_EQ(rest.push(row == 50 ? kMissing : 1.0, true).deg_per_h, 0);
  EXPECT_EQ(rest.push(1, true).deg_per_h, 0);
  for (int row = 0; row < kRows; ++row) rest.push(1, true);
  EXPECT_GT(rest.push(1, true).deg_per_h, 0);
}

TEST(RestTracker, PassesMissingRowsAsIfTheyWereNotKnown) {
  for (const int missing : {1, 60, 99, 100, 101, 350, 1000}) {
    RestTracker passing(virtual_space(), kRows), pushing(virtual_space(), kRows);
    for (RestTracker* tracker : {&passing, &pushing})
      for (int row = 0; row < 940; ++row) tracker->push(1, true);
    passing.pass(missing);
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
