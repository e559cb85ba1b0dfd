// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "simulator/thermometer_bank.hpp"
#include "simulator/virtual_gyro.hpp"
#include "tests/simulator/small_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

ReducedGyroParameters small_type() {
  ReducedGyroParameters type;
  type.model = small_gyro();
  type.start_c = 20;
  type.film = thermal::GyroFilm::chamber;
  type.bias.flow = {.shift_deg_per_h_per_cm_per_s = 4.4, .velocity_cm_per_s = 1.5, .exponent = 0.7, .unbalance = 0};
  type.bias.mirror_deg_per_h_per_k = {5e-3, -4e-3, 3e-3, 6e-3};
  return type;
}

double at(const ReducedGyro& gyro, thermal::ThermalOutput output) {
  return gyro.inner_c()[static_cast<std::size_t>(output)];
}

TEST(ReducedGyro, StaysAtRest) {
  ReducedGyro gyro(small_type());
  const double rest_c = gyro.locations_c()[0];
  const double rest_bias = gyro.bias().value;
  EXPECT_GT(rest_c, 22) << "the gyro is switched on";
  for (int t = 0; t < 3600; ++t) gyro.step({20}, 0);
  EXPECT_NEAR(gyro.locations_c()[0], rest_c, 1e-6);
  EXPECT_NEAR(gyro.bias().value, rest_bias, 1e-9);
}

TEST(ReducedGyro, HasNoGasFlowWithEqualArms) {
  ReducedGyro gyro(small_type());
  for (int t = 0; t < 1800; ++t) {
    gyro.step({20 - 0.03 * t}, 0);
    ASSERT_NEAR(gyro.bias_parts().gas_flow, 0, 1e-9) << t;
  }
}

TEST(ReducedGyro, WarmsStrongerArmAtEqualTotalPower) {
  auto type = small_type();
  type.arms.gain_left_over_right = 1.1;
  const auto model = apply_unequal_arms(type.model, type.arms);
  EXPECT_NEAR(model.powers_w[0] / model.powers_w[1], 1.1, 1e-12);
  EXPECT_NEAR(model.powers_w[0] + model.powers_w[1], 0.588, 1e-12);
  const ReducedGyro gyro(type);
  EXPECT_GT(at(gyro, thermal::ThermalOutput::gain_left), at(gyro, thermal::ThermalOutput::gain_right));
  EXPECT_GT(gyro.bias_parts().gas_flow, 0);
}

/// At rest, the heat through the film equals the sum of all sources, whatever path the heat takes.
TEST(ReducedGyro, ConservesHeatInLeads) {
  auto type = small_type();
  const ReducedGyro without(type);
  type.arms.left_lead_w_per_k = 0.01;
  const ReducedGyro with(type);
  EXPECT_NEAR(at(with, thermal::ThermalOutput::shell), at(without, thermal::ThermalOutput::shell), 1e-6);
  EXPECT_LT(at(with, thermal::ThermalOutput::gain_left), at(without, thermal::ThermalOutput::gain_left) - 0.1);
  EXPECT_LT(at(with, thermal::ThermalOutput::gain_left), at(with, thermal::ThermalOutput::gain_right));
}

TEST(ReducedGyro, SeparatesArmsInRampWithUnequalLeads) {
  auto type = small_type();
  type.arms.left_lead_w_per_k = 0.01;
  ReducedGyro gyro(type);
  const double at_rest_k = at(gyro, thermal::ThermalOutput::gain_left) - at(gyro, thermal::ThermalOutput::gain_right);
  for (int t = 0; t < 1200; ++t) gyro.step({20 + t / 30.0}, 0);
  const double in_ramp_k = at(gyro, thermal::ThermalOutput::gain_left) - at(gyro, thermal::ThermalOutput::gain_right);
  EXPECT_LT(at_rest_k, 0);
  EXPECT_GT(in_ramp_k, 0) << "the lead warms its arm";
}

TEST(ReducedGyro, IsCoolerUnderFan) {
  auto type = small_type();
  const ReducedGyro in_chamber(type);
  type.film = thermal::GyroFilm::still;
  EXPECT_GT(ReducedGyro(type).locations_c()[8], in_chamber.locations_c()[8] + 1);
}

LaboratoryParameters small_laboratory() {
  LaboratoryParameters laboratory;
  auto type = small_type();
  type.bias.waves = {{1e-3, 50, 0}};
  type.bias.plays = {{5, 1e-3}};
  type.arms = {.left_lead_w_per_k = 1e-3, .right_lead_w_per_k = 2e-3};
  type.spread = {.capacity = 0.05, .gap = 0.1, .film = 0.1, .power = 0.02, .arms = 0.02};
  type.lead_spread = 0.2;
  laboratory.body = type;
  laboratory.spread = {.bias = 0.2, .offset_k = 0.02, .gain = 1e-3, .time_constant = 0.2, .turn_on_deg_per_h = 0.002};
  laboratory.thermometers.time_constant_s.fill(5);
  return laboratory;
}

TEST(DrawGyro, KeepsTwinOfFileForSeedZero) {
  const auto type = small_laboratory();
  const auto drawn = draw_gyro(type, 0);
  const auto& before = std::get<ReducedGyroParameters>(type.body);
  const auto& after = std::get<ReducedGyroParameters>(drawn.body);
  EXPECT_EQ(after.model.conduction, before.model.conduction);
  EXPECT_EQ(after.model.powers_w, before.model.powers_w);
  EXPECT_EQ(after.bias.mirror_deg_per_h_per_k, before.bias.mirror_deg_per_h_per_k);
  EXPECT_EQ(after.arms.left_lead_w_per_k, before.arms.left_lead_w_per_k);
  EXPECT_EQ(drawn.thermometers.time_constant_s, type.thermometers.time_constant_s);
}

/// All heat leaves through the film. Neither leads nor spread change this balance.
TEST(DrawGyro, ConservesHeat) {
  auto type = small_laboratory();
  auto without_leads = type;
  std::get<ReducedGyroParameters>(without_leads.body).arms = {};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ReducedGyro with(std::get<ReducedGyroParameters>(draw_gyro(type, seed).body));
    const ReducedGyro without(std::get<ReducedGyroParameters>(draw_gyro(without_leads, seed).body));
    EXPECT_NEAR(at(with, thermal::ThermalOutput::shell), at(without, thermal::ThermalOutput::shell), 1e-6) << seed;
    EXPECT_NE(at(with, thermal::ThermalOutput::gain_left), at(without, thermal::ThermalOutput::gain_left)) << seed;
  }
}

TEST(DrawGyro, DrawsAnotherTwinForEachSeed) {
  const auto type = small_laboratory();
  const auto& first = std::get<ReducedGyroParameters>(type.body);
  double squares = 0;
  constexpr int kGyros = 400;
  for (std::uint64_t seed = 1; seed <= kGyros; ++seed) {
    const auto drawn = draw_gyro(type, seed);
    const auto& other = std::get<ReducedGyroParameters>(drawn.body);
    ASSERT_NE(other.model.conduction, first.model.conduction) << seed;
    ASSERT_NE(other.bias.waves[0].phase_deg, first.bias.waves[0].phase_deg) << seed;
    ASSERT_NE(other.bias.plays[0].deg_per_h, first.bias.plays[0].deg_per_h) << seed;
    ASSERT_NE(drawn.thermometers.gain[3], 0) << seed;
    ASSERT_NE(drawn.thermometers.time_constant_s[0], drawn.thermometers.time_constant_s[1]) << seed;
    ASSERT_NE(drawn.gyro.turn_on_deg_per_h, 0) << seed;
    squares += std::pow(std::log(other.bias.mirror_deg_per_h_per_k[1] / -4e-3), 2);
  }
  EXPECT_NEAR(std::sqrt(squares / kGyros), 0.2, 4 * 0.2 / std::sqrt(2.0 * kGyros));
}

}  // namespace
}  // namespace gyrotherm::simulator
