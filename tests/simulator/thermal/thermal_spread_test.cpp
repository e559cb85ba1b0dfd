// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "simulator/thermal/reduced/reduced_model.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr ThermalSpread kWide{.capacity = 0.05, .gap = 0.2, .film = 0.3, .power = 0.1, .arms = 0.1};

RandomStream stream(std::uint64_t seed) { return {seed, RandomPurpose::capacity_spread}; }

TEST(ThermalSpread, KeepsGyroWithoutSpread) {
  auto random = stream(5);
  const auto other = perturb_model(reduced_box_gyro(), {}, random);
  EXPECT_EQ(reduced_model_text(other), reduced_model_text(reduced_box_gyro()));
}

TEST(ThermalSpread, DrawsSameCountForAnySpread) {
  auto narrow = stream(5);
  auto wide = stream(5);
  (void)perturb_model(reduced_box_gyro(), {}, narrow);
  (void)perturb_model(reduced_box_gyro(), kWide, wide);
  EXPECT_EQ(narrow.uniform(), wide.uniform());
}

TEST(ThermalSpread, DrawsOnlyValidBodies) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    auto random = stream(seed);
    const auto other = perturb_model(reduced_box_gyro(), kWide, random);
    // The parser rejects invalid bodies.
    const auto back = parse_reduced_model(reduced_model_text(other), "x.toml");
    ASSERT_TRUE(back) << text(back.error());
    EXPECT_EQ(other.conduction, other.conduction.transpose());
  }
}

TEST(ThermalSpread, DrawsUnequalArmsWithConstantSum) {
  const auto& type = reduced_box_gyro();
  auto random = stream(7);
  const auto other = perturb_model(type, {.arms = 0.2}, random);
  EXPECT_NEAR(other.powers_w[0] + other.powers_w[1], type.powers_w[0] + type.powers_w[1], 1e-15);
  EXPECT_NE(other.powers_w[0], other.powers_w[1]);
  EXPECT_NEAR(other.powers_w[3] + other.powers_w[4], type.powers_w[3] + type.powers_w[4], 1e-15);
  const auto c = coefficients_at(other, 20, GyroFilm::chamber);
  const Eigen::VectorXd rest = other.outputs * (states_at(other, c, 0) * operating_inputs(other, 20));
  EXPECT_GT(std::abs(rest[9] - rest[10]), 1e-2);
}

TEST(ThermalSpread, ChangesRateButNotRestByCapacity) {
  const auto& type = reduced_box_gyro();
  auto random = stream(7);
  const auto other = perturb_model(type, {.capacity = 0.2}, random);
  const auto c = coefficients_at(type, 20, GyroFilm::chamber);
  const auto rest = [&](const ReducedModel& m) -> Eigen::VectorXd {
    return m.outputs * (states_at(m, c, 0) * operating_inputs(m, 20));
  };
  EXPECT_LE((rest(type) - rest(other)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NE(conduction_at(type, c)(3, 3), conduction_at(other, c)(3, 3));
}

}  // namespace
}  // namespace gyrotherm::thermal
