// SPDX-License-Identifier: Apache-2.0
#include "core/random.hpp"

#include <gtest/gtest.h>

#include "tests/support/statistics.hpp"

namespace gyrotherm {
namespace {

TEST(RandomStream, MatchesReferenceOnEveryPlatform) {
  // The published first output for the seed 0.
  EXPECT_EQ(splitmix64(0), 0xe220a8397b1dcdafU);
  RandomStream stream(1, RandomPurpose::angle_noise);
  std::mt19937_64 engine(splitmix64(splitmix64(1) + 8));
  EXPECT_EQ(stream.uniform(), static_cast<double>(engine() >> 11U) / 9007199254740992.0);
}

TEST(RandomStream, DiffersByPurposeAndBySeed) {
  const double first = RandomStream(1, RandomPurpose::angle_noise).uniform();
  EXPECT_NE(first, RandomStream(1, RandomPurpose::drift).uniform());
  EXPECT_NE(first, RandomStream(2, RandomPurpose::angle_noise).uniform());
}

TEST(RandomStream, HasFirstFourNormalMoments) {
  RandomStream stream(20151130, RandomPurpose::angle_noise);
  std::vector<double> values(400000);
  for (double& value : values) value = stream.normal();
  double fourth = 0;
  double third = 0;
  for (const double value : values) {
    third += value * value * value;
    fourth += value * value * value * value;
  }
  const double n = static_cast<double>(values.size());
  EXPECT_NEAR(tests::mean_of(values), 0, 4 / std::sqrt(n));
  EXPECT_NEAR(tests::standard_deviation(values), 1, 4 / std::sqrt(2 * n));
  EXPECT_NEAR(third / n, 0, 4 * std::sqrt(15 / n));
  EXPECT_NEAR(fourth / n, 3, 4 * std::sqrt(96 / n));
}

}  // namespace
}  // namespace gyrotherm
