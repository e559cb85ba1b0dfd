// SPDX-License-Identifier: Apache-2.0
/// Compares the contributions to the bias with the literature from which they are taken.
#include "simulator/gyro_bias.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/random.hpp"

namespace gyrotherm::simulator {
namespace {

using Inner = std::array<double, thermal::kThermalOutputs>;

constexpr GasFlow kFlow{.shift_deg_per_h_per_cm_per_s = 4.4, .velocity_cm_per_s = 1.5, .exponent = 0.7, .unbalance = 0};

Inner even(double celsius) {
  Inner inner{};
  inner.fill(celsius);
  return inner;
}

double& at(Inner& inner, thermal::ThermalOutput output) { return inner[static_cast<std::size_t>(output)]; }

BiasPhysics complete_physics() {
  return {.flow = {4.4, 1.5, 0.7, 1e-3},
          .mirror_deg_per_h_per_k = {5e-3, -4e-3, 3e-3, 6e-3},
          .linear_deg_per_h_per_k = -1e-4,
          .quadratic_deg_per_h_per_k2 = 1e-6,
          .waves = {{1e-3, 50, 30}},
          .plays = {{5, 1e-3}, {15, 5e-4}},
          .mode_hops = {60, 0.6, 0.01}};
}

/// At 300 K, the flow changes by 0.23 % per kelvin. With the published shift and 1.5 cm/s, this is 0.015 °/h per
/// kelvin.
TEST(GasFlow, ChangesWithViscosityOfWarmerArm) {
  const double flow_at_300_k = 4.4 * 1.5 * std::pow(300 / 293.15, 0.7);
  EXPECT_NEAR(gas_flow_deg_per_h(kFlow, 27.35, 26.35) / flow_at_300_k, 0.0023, 0.00005);
  EXPECT_NEAR(gas_flow_deg_per_h(kFlow, 20.5, 19.5), 4.4 * 1.5 * 0.7 / 293.15, 1e-7);
  EXPECT_DOUBLE_EQ(gas_flow_deg_per_h(kFlow, 27.35, 26.35), -gas_flow_deg_per_h(kFlow, 26.35, 27.35));
}

TEST(GasFlow, CancelsForEqualArms) {
  for (const double t : {-40.0, 20.0, 60.0}) EXPECT_EQ(gas_flow_deg_per_h(kFlow, t, t), 0);
}

TEST(GasFlow, GrowsWithTemperatureForUnequalCurrents) {
  auto unequal = kFlow;
  unequal.unbalance = 1e-3;
  EXPECT_NEAR(gas_flow_deg_per_h(unequal, 20, 20), 4.4 * 1.5 * 1e-3, 1e-15);
  EXPECT_NEAR(gas_flow_deg_per_h(unequal, 60, 60) / gas_flow_deg_per_h(unequal, 20, 20), std::pow(333.15 / 293.15, 0.7),
              1e-12);
}

TEST(Deformation, RequiresGradient) {
  const auto physics = complete_physics();
  EXPECT_EQ(deformation_deg_per_h(physics, even(45)), 0);
  auto inner = even(45);
  at(inner, thermal::ThermalOutput::mirror_c) += 2;
  at(inner, thermal::ThermalOutput::mirror_h) -= 1;
  EXPECT_NEAR(deformation_deg_per_h(physics, inner), 2 * -4e-3 - 6e-3, 1e-15);
}

TEST(TemperaturePart, IsZeroAt20AndQuadratic) {
  const auto physics = complete_physics();
  EXPECT_EQ(temperature_deg_per_h(physics, 20), 0);
  EXPECT_NEAR(temperature_deg_per_h(physics, 60), -1e-4 * 40 + 1e-6 * 1600, 1e-15);
  EXPECT_NEAR(temperature_deg_per_h(physics, -40), 1e-4 * 60 + 1e-6 * 3600, 1e-15);
}

TEST(Backscatter, RepeatsWithPeriod) {
  const std::vector<BackscatterWave> waves{{1e-3, 50, 30}};
  EXPECT_NEAR(backscatter_deg_per_h(waves, 20), 1e-3 * 0.5, 1e-15);
  for (const double path : {-37.0, 3.0, 41.0})
    EXPECT_NEAR(backscatter_deg_per_h(waves, path), backscatter_deg_per_h(waves, path + 50), 1e-15) << path;
}

TEST(GyroBias, IsSumOfParts) {
  GyroBias bias(complete_physics(), even(20));
  auto inner = even(58);
  at(inner, thermal::ThermalOutput::gain_left) = 60;
  at(inner, thermal::ThermalOutput::mirror_b) = 59;
  bias.step(inner);
  const auto& p = bias.parts();
  for (const double part : {p.gas_flow, p.deformation, p.temperature, p.backscatter, p.hysteresis, p.mode_hops})
    EXPECT_NE(part, 0);
  EXPECT_DOUBLE_EQ(bias.total().value,
                   p.gas_flow + p.deformation + p.temperature + p.backscatter + p.hysteresis + p.mode_hops);
}

TEST(GyroBias, DiffersBetweenHeatingAndCoolingByHysteresis) {
  GyroBias bias(complete_physics(), even(20));
  EXPECT_EQ(bias.parts().hysteresis, 0);
  bias.step(even(50));
  EXPECT_NEAR(bias.parts().hysteresis, 1.5e-3, 1e-15);
  bias.step(even(20));
  EXPECT_NEAR(bias.parts().hysteresis, -1.5e-3, 1e-15) << "the play has fully reversed";
}

/// The temperatures that determine the bias must not be those that the analysis reads.
TEST(GyroBias, DoesNotDependOnThermometerLocations) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomStream random(seed, RandomPurpose::bias_spread);
    auto inner = even(0);
    GyroBias plain(complete_physics(), inner);
    GyroBias with_other_places(complete_physics(), inner);
    for (int t = 0; t < 50; ++t) {
      for (double& celsius : inner) celsius = 20 + 30 * random.normal();
      plain.step(inner);
      for (auto place = thermal::ThermalOutput::a; place <= thermal::ThermalOutput::shell;
           place = static_cast<thermal::ThermalOutput>(static_cast<std::size_t>(place) + 1))
        at(inner, place) = 100 * random.normal();
      with_other_places.step(inner);
      ASSERT_EQ(plain.total().value, with_other_places.total().value) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace gyrotherm::simulator
