// SPDX-License-Identifier: Apache-2.0
/// Tests the bias of the reference simulation at scale 1, without noise.
#include "simulator/lumped_gyro.hpp"

#include <gtest/gtest.h>

#include <iterator>

#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr double kSixthDecimal = 0.5e-6 + 1e-12;

std::vector<double> biases_of(const LumpedGyroParameters& parameters, const std::vector<double>& air_c) {
  LumpedGyro gyro(parameters);
  std::vector<double> biases;
  for (const double air : air_c) {
    biases.push_back(gyro.bias().value);
    gyro.step({air}, 0);
  }
  return biases;
}

struct Anchor {
  const char* rig;
  double all_cycles;
  std::vector<double> by_cycle;
  double at_rest;
  /// At the scale of the file.
  double random_profile;
};

class ReferenceBiasLaw : public testing::TestWithParam<Anchor> {};

TEST_P(ReferenceBiasLaw, MatchesReferenceDeviationInRateCycles) {
  auto gyro = lumped_of_rig(GetParam().rig);
  gyro.bias.scale = 1;
  std::vector<double> all;
  const std::vector<double> rates{1, 2, 3, 5};
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const auto cycle = tests::clusters_of(biases_of(gyro, rate_cycle_c(rates[i])));
    EXPECT_NEAR(tests::standard_deviation(cycle), GetParam().by_cycle[i], kSixthDecimal);
    all.insert(all.end(), cycle.begin(), cycle.end());
  }
  EXPECT_NEAR(tests::standard_deviation(all), GetParam().all_cycles, kSixthDecimal);
}

TEST_P(ReferenceBiasLaw, HasRestValueOfReferenceAt20) {
  auto gyro = lumped_of_rig(GetParam().rig);
  gyro.bias.scale = 1;
  EXPECT_NEAR(biases_of(gyro, {20}).front(), GetParam().at_rest, kSixthDecimal);
}

TEST_P(ReferenceBiasLaw, HasDeviationOfReferenceInRandomProfile) {
  const auto gyro = lumped_of_rig(GetParam().rig);
  const auto clusters = tests::clusters_of(biases_of(gyro, random_profile_c()));
  ASSERT_EQ(clusters.size(), 1440U);
  EXPECT_NEAR(tests::standard_deviation(clusters), GetParam().random_profile, kSixthDecimal);
}

TEST_P(ReferenceBiasLaw, IsScaledToDeviationOfPaper) {
  const auto scale = lumped_of_rig(GetParam().rig).bias.scale;
  EXPECT_NEAR(scale * GetParam().all_cycles, 0.025735, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Rigs, ReferenceBiasLaw,
    testing::Values(Anchor{"virtual-gradients", 0.020015, {0.017292, 0.020292, 0.021242, 0.021872}, 0.014755, 0.013748},
                    Anchor{
                        "virtual-reference", 0.019448, {0.016980, 0.019713, 0.020571, 0.021134}, 0.014738, 0.013706}),
    [](const auto& rig) { return std::string(rig.index == 0 ? "FollowsGradientsAlone" : "FollowsTemperatureToo"); });

}  // namespace
}  // namespace gyrotherm::simulator
