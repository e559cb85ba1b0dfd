// SPDX-License-Identifier: Apache-2.0
#include "simulator/gyro_ageing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

LaboratoryParameters hard_gyro_after(std::uint64_t days) {
  return age_gyro(laboratory_of_rig("virtual-hard"), {.gyro = 5, .run = 1, .days_later = days});
}

const BiasPhysics& bias_of(const LaboratoryParameters& laboratory) {
  return std::get<ReducedGyroParameters>(laboratory.body).bias;
}

TEST(Ageing, IsLinearInTime) {
  const auto now = hard_gyro_after(0), month = hard_gyro_after(30), year = hard_gyro_after(365);
  for (std::size_t i = 0; i < 4; ++i) {
    const double by_then = bias_of(year).mirror_deg_per_h_per_k[i] - bias_of(now).mirror_deg_per_h_per_k[i];
    EXPECT_NEAR((bias_of(month).mirror_deg_per_h_per_k[i] - bias_of(now).mirror_deg_per_h_per_k[i]) / by_then,
                30.0 / 365, 1e-9);
  }
  EXPECT_NEAR(bias_of(year).flow.velocity_cm_per_s / bias_of(now).flow.velocity_cm_per_s, 1.03, 1e-12);
  EXPECT_NEAR(bias_of(year).flow.unbalance / bias_of(now).flow.unbalance, 1.01, 1e-12);
}

TEST(Ageing, ContinuesDriftOfThermometer) {
  const EachThermometer sigma = laboratory_of_rig("virtual-hard").thermometers.drift_k_per_sqrt_day;
  const auto month = calendar_drift_k(sigma, 5, 0, 30), rest = calendar_drift_k(sigma, 5, 30, 365);
  const auto year = calendar_drift_k(sigma, 5, 0, 365);
  for (std::size_t i = 0; i < year.size(); ++i) EXPECT_NEAR(month[i] + rest[i], year[i], 1e-12);
}

TEST(Ageing, GrowsThermometerDriftWithRootOfDays) {
  EachThermometer sigma{};
  sigma.fill(0.0026);
  std::vector<double> after_a_year;
  for (std::uint64_t gyro = 0; gyro < 100; ++gyro)
    for (const double drift_k : calendar_drift_k(sigma, gyro, 0, 365)) after_a_year.push_back(drift_k);
  EXPECT_NEAR(tests::standard_deviation(after_a_year) / 0.0497, 1, 4 / std::sqrt(1800.0));
}

TEST(Ageing, HasSameDriftForRunsOfOneDay) {
  auto type = laboratory_of_rig("virtual-hard");
  type.thermometers.noise_k.fill(0);
  type.thermometers.resolution_k.fill(0);
  const VirtualLaboratory one(type, {.gyro = 5, .run = 1}), other(type, {.gyro = 5, .run = 2});
  EXPECT_TRUE(std::ranges::equal(one.thermometers_as_measured_c(), other.thermometers_as_measured_c()));
  const VirtualLaboratory later(type, {.gyro = 5, .run = 1, .days_later = 30});
  EXPECT_FALSE(std::ranges::equal(one.thermometers_as_measured_c(), later.thermometers_as_measured_c()));
}

TEST(Ageing, LeavesLinearRigUnchangedOnDayZero) {
  const auto type = laboratory_of_rig("virtual");
  const auto same = age_gyro(type, {.gyro = 3, .run = 7});
  EXPECT_EQ(same.thermometers.offset_k, type.thermometers.offset_k);
  EXPECT_EQ(same.thermometers.days_since_calibration, type.thermometers.days_since_calibration);
  EXPECT_EQ(bias_of(same).mirror_deg_per_h_per_k, bias_of(type).mirror_deg_per_h_per_k);
}

TEST(Ageing, DrawsAnotherRunOnAnotherDay) {
  EXPECT_NE(noise_seed({.gyro = 1, .run = 2, .days_later = 1}), noise_seed({.gyro = 1, .run = 2}));
  EXPECT_NE(noise_seed({.gyro = 1, .run = 2, .days_later = 1}), noise_seed({.gyro = 1, .run = 2, .days_later = 2}));
}

TEST(Storage, AddsOneTurnPerDay) {
  const StorageTemperatures storage{.turns = 20, .lowest_c = -40, .highest_c = 60};
  const auto first = make_history(storage, {.gyro = 5}).turning_points_c;
  const auto later = make_history(storage, {.gyro = 5, .run = 9, .days_later = 30}).turning_points_c;
  EXPECT_EQ(first.size(), 20u);
  EXPECT_EQ(later.size(), 50u);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), later.begin()));
  EXPECT_GE(*std::ranges::min_element(later), -40);
  EXPECT_LE(*std::ranges::max_element(later), 60);
  EXPECT_TRUE(make_history({}, {.gyro = 5, .days_later = 30}).turning_points_c.empty()) << "the gyro has relaxed";
}

}  // namespace
}  // namespace gyrotherm::simulator
