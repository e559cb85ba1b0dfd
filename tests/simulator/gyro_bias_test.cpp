/// The reference simulation's bias, free of noise, at scale 1.
#include "simulator/gyro_bias.hpp"

#include <gtest/gtest.h>

#include <iterator>

#include "simulator/thermal_network.hpp"
#include "tests/simulator/laboratory.hpp"
#include "tests/simulator/statistics.hpp"

namespace gyrotherm {
namespace {

constexpr double kSixthDecimal = 0.5e-6 + 1e-12;

std::vector<double> biases_of(const WorldParameters& world, const std::vector<double>& air_c) {
  ThermalNetwork network(world.network);
  std::vector<double> biases;
  for (const double air : air_c) {
    biases.push_back(thermal_bias(world.bias, network.temperatures_c().first<kBlockPlaces>()).value);
    network.step({air});
  }
  return biases;
}

struct Anchor {
  const char* rig;
  double all_cycles;
  std::vector<double> by_cycle;
  double at_rest;
  double random_profile;  ///< with the file's own scale
};

class GyroBias : public testing::TestWithParam<Anchor> {};

TEST_P(GyroBias, DeviatesAsTheReferenceDoesInTheRateCycles) {
  auto world = world_of_rig(GetParam().rig);
  world.bias.scale = 1;
  std::vector<double> all;
  const std::vector<double> rates{1, 2, 3, 5};
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const auto cycle = clusters_of(biases_of(world, rate_cycle_c(rates[i])));
    EXPECT_NEAR(standard_deviation_of(cycle), GetParam().by_cycle[i], kSixthDecimal);
    all.insert(all.end(), cycle.begin(), cycle.end());
  }
  EXPECT_NEAR(standard_deviation_of(all), GetParam().all_cycles, kSixthDecimal);
}

TEST_P(GyroBias, RestsAt20WhereTheReferenceDoes) {
  auto world = world_of_rig(GetParam().rig);
  world.bias.scale = 1;
  EXPECT_NEAR(biases_of(world, {20}).front(), GetParam().at_rest, kSixthDecimal);
}

TEST_P(GyroBias, DeviatesAsTheReferenceDoesInTheRandomProfile) {
  const auto world = world_of_rig(GetParam().rig);
  const auto clusters = clusters_of(biases_of(world, random_profile_c()));
  ASSERT_EQ(clusters.size(), 1440U);
  EXPECT_NEAR(standard_deviation_of(clusters), GetParam().random_profile, kSixthDecimal);
}

TEST_P(GyroBias, IsScaledToTheDeviationOfThePaper) {
  const auto scale = world_of_rig(GetParam().rig).bias.scale;
  EXPECT_NEAR(scale * GetParam().all_cycles, 0.025735, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Rigs, GyroBias,
    testing::Values(Anchor{"virtual-gradients", 0.020015, {0.017292, 0.020292, 0.021242, 0.021872}, 0.014755, 0.013748},
                    Anchor{"virtual", 0.019448, {0.016980, 0.019713, 0.020571, 0.021134}, 0.014738, 0.013706}),
    [](const auto& rig) { return std::string(rig.index == 0 ? "FollowsGradientsAlone" : "FollowsTemperatureToo"); });

}  // namespace
}  // namespace gyrotherm
