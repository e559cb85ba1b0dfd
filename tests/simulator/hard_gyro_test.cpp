// SPDX-License-Identifier: Apache-2.0
/// Tests each bias term that the hard rig has in addition to those of the linear rig.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "simulator/chamber_plant.hpp"
#include "simulator/gyro_bias.hpp"
#include "simulator/gyro_readout.hpp"
#include "simulator/thermometer_bank.hpp"
#include "simulator/virtual_gyro.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

/// Returns the same temperature for every output of the thermal model.
std::array<double, thermal::kThermalOutputs> equal_temperatures(double celsius) {
  std::array<double, thermal::kThermalOutputs> inner{};
  inner.fill(celsius);
  return inner;
}

std::array<double, kThermalLocations> places_at(double celsius) {
  std::array<double, kThermalLocations> places{};
  places.fill(celsius);
  return places;
}

TEST(CoefficientGrowth, IsGammaOver40KelvinOfBlock) {
  BiasPhysics physics;
  physics.mirror_deg_per_h_per_k = {1e-3, 0, 0, 0};
  physics.growth.mirrors = {0.3, 0, 0, 0};
  for (const double block_c : {-40.0, 20.0, 60.0}) {
    auto inner = equal_temperatures(block_c);
    inner[static_cast<std::size_t>(thermal::ThermalOutput::mirror_b)] += 2;
    EXPECT_NEAR(deformation_deg_per_h(physics, inner), 2e-3 * (1 + 0.3 * (block_c - 20) / 40), 1e-15);
  }
}

TEST(HiddenLag, FollowsWithTimeConstant) {
  LaggingPart part({.share = 0.4, .time_constant_s = 300});
  EXPECT_EQ(part.follow(0), 0);
  EXPECT_NEAR(part.follow(1), 0.6, 0.002) << "the remainder follows immediately";
  double after = 0;
  for (int t = 1; t < 300; ++t) after = part.follow(1);
  EXPECT_NEAR(after, 0.6 + 0.4 * (1 - std::exp(-1)), 1e-12);
}

TEST(HiddenLag, IsZeroAtRest) {
  LaggingPart part({.share = 0.4, .time_constant_s = 300});
  for (int t = 0; t < 10; ++t) EXPECT_DOUBLE_EQ(part.follow(0.7), 0.7);
}

TEST(Relaxation, DecaysWithTimeConstantsAfterJump) {
  RelaxingBias bias({{1800, 2e-5}, {36000, -1e-5}}, 20);
  bias.follow(20);
  EXPECT_EQ(bias.deg_per_h(), 0);
  double passed = 0;
  for (const double until : {1, 1800, 36000}) {
    for (; passed < until; ++passed) bias.follow(60);
    EXPECT_NEAR(bias.deg_per_h(), 40 * (2e-5 * std::exp(-passed / 1800) - 1e-5 * std::exp(-passed / 36000)), 1e-12);
  }
}

constexpr GasFlow kControlled{
    .shift_deg_per_h_per_cm_per_s = 4.4, .velocity_cm_per_s = 1.5, .exponent = 0.7, .unbalance_per_k = 3e-5};

TEST(CurrentControl, ChangesUnbalanceWithElectronicsTemperature) {
  BiasPhysics physics;
  physics.flow = kControlled;
  GyroBias bias(physics, equal_temperatures(20));
  EXPECT_EQ(bias.total().value, 0);
  auto inner = equal_temperatures(20);
  inner[static_cast<std::size_t>(thermal::ThermalOutput::preamplifier)] = 60;
  bias.step(inner);
  EXPECT_NEAR(bias.total().value, 40 * 3e-5 * 4.4 * 1.5, 1e-12) << "immediately";
}

/// Means over 100 s of the bias and of the thermometers without faults.
struct Means {
  std::vector<std::array<double, kThermalLocations>> locations_c;
  std::vector<double> bias;
};

Means fast_cycle_means(const ReducedGyroParameters& parameters) {
  ChamberPlant plant(laboratory_of_rig("virtual").plant);
  ReducedGyro gyro(parameters);
  Means means;
  int second = 0;
  for (const double set_point_c : rate_cycle_c(5)) {
    if (second++ % 100 == 0) {
      means.locations_c.push_back({});
      means.bias.push_back(0);
    }
    for (std::size_t i = 0; i < kThermalLocations; ++i) means.locations_c.back()[i] += gyro.locations_c()[i] / 100;
    means.bias.back() += gyro.bias().value / 100;
    gyro.step(plant.air(), plant.output_percent() / 100);
    plant.step({set_point_c}, true);
  }
  return means;
}

/// Returns the RMS residual of a least-squares fit to all nine temperatures, which are delayed by `late` means.
double fit_residual(const Means& means, std::size_t late) {
  const auto rows = static_cast<Eigen::Index>(means.bias.size() - late);
  Eigen::MatrixXd inputs(rows, kThermalLocations + 1);
  Eigen::VectorXd bias(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto& locations_c = means.locations_c[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < kThermalLocations; ++i) inputs(k, static_cast<Eigen::Index>(i)) = locations_c[i] - 20;
    inputs(k, kThermalLocations) = 1;
    bias(k) = means.bias[static_cast<std::size_t>(k) + late];
  }
  const Eigen::VectorXd weights = inputs.colPivHouseholderQr().solve(bias);
  return std::sqrt((bias - inputs * weights).squaredNorm() / static_cast<double>(rows));
}

TEST(CurrentControl, LeavesResidualWithDelayedInputs) {
  auto alone = reduced_of_rig("virtual");
  const auto linear = fast_cycle_means(alone);
  EXPECT_LT(fit_residual(linear, 3), 1.2 * fit_residual(linear, 0)) << "delayed inputs explain a linear gyro as well";
  alone.bias.flow.unbalance_per_k = reduced_of_rig("virtual-hard").bias.flow.unbalance_per_k;
  const auto fast = fast_cycle_means(alone);
  EXPECT_GT(fit_residual(fast, 3), 1.3 * fit_residual(fast, 0));
}

/// The thermometers of a linear gyro represent the effect of the wind. Those of a hard gyro cannot, because its
/// coefficients grow and lag.
TEST(SideWind, LeavesLargerResidualOfHardGyro) {
  auto linear = reduced_of_rig("virtual"), hard = reduced_of_rig("virtual-hard");
  linear.wind = hard.wind;
  const double windy = fit_residual(fast_cycle_means(linear), 0);
  const double hard_windy = fit_residual(fast_cycle_means(hard), 0);
  linear.wind = hard.wind = {};
  EXPECT_NEAR(windy / fit_residual(fast_cycle_means(linear), 0), 1, 0.1);
  EXPECT_GT(hard_windy, 1.1 * fit_residual(fast_cycle_means(hard), 0));
}

TEST(WarmUp, IsSumOfPhases) {
  BiasPhysics physics;
  physics.warm_up = {{120, 0.01}, {7200, 0.002}};
  GyroBias bias(physics, equal_temperatures(20));
  EXPECT_DOUBLE_EQ(bias.total().value, 0.012);
  for (int t = 0; t < 120; ++t) bias.step(equal_temperatures(20));
  EXPECT_NEAR(bias.total().value, 0.01 * std::exp(-1) + 0.002 * std::exp(-1 / 60.0), 1e-15);
}

TEST(Hysteresis, DependsOnPreviousRun) {
  BiasPhysics physics;
  physics.plays = {{4, 1e-3}, {30, 1e-3}};
  GyroBias warmed(physics, equal_temperatures(20), {.turning_points_c = {-40, 60}});
  GyroBias cooled(physics, equal_temperatures(20), {.turning_points_c = {60, -40}});
  EXPECT_NEAR(warmed.total().value, -1e-3 - 1e-3 / 3, 1e-15)
      << "approached from above; the wide play has moved 10 of its 30 K";
  EXPECT_NEAR(cooled.total().value, 2e-3, 1e-15);
  for (auto* bias : {&warmed, &cooled})
    for (const double wider_c : {-50.0, 70.0, 20.0}) bias->step(equal_temperatures(wider_c));
  EXPECT_EQ(warmed.total().value, cooled.total().value) << "a wider excursion erases the history";
}

TEST(HardGyro, HopsWithinTwoToTwentySeconds) {
  const auto hops = reduced_of_rig("virtual-hard").bias.mode_hops;
  std::set<int> lengths;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    ModeLock lock(hops, 20, RandomStream(seed, RandomPurpose::mode_hops));
    ASSERT_EQ(lock.deg_per_h(), 0);
    lock.follow(20 + 40);
    ASSERT_EQ(lock.mode(), 1);
    ASSERT_DOUBLE_EQ(lock.deg_per_h(), hops.transient_deg_per_h) << "the transient precedes the step";
    int lasted_s = 0;
    for (; lock.is_hopping(); ++lasted_s) lock.follow(20 + 40);
    ASSERT_EQ(lock.deg_per_h(), hops.step_deg_per_h) << "the hop has ended";
    lengths.insert(lasted_s);
  }
  EXPECT_GE(*lengths.begin(), 2);
  EXPECT_LE(*lengths.rbegin(), 20);
  EXPECT_GT(lengths.size(), 10u) << "each hop has its own duration";
}

TEST(HardGyro, HopsAtTemperaturesIndependentOfStart) {
  const auto hops = reduced_of_rig("virtual-hard").bias.mode_hops;
  ModeLock warm(hops, 20), cold(hops, -40);
  for (double path_c = -40; path_c < 60; path_c += 0.1) cold.follow(path_c);
  for (double path_c = 20; path_c < 60; path_c += 0.1) warm.follow(path_c);
  EXPECT_EQ(warm.mode(), 1);
  EXPECT_EQ(cold.mode(), warm.mode());
}

/// Simulates the cycle at 1 °C/min in the air of the simulated chamber.
TEST(HardGyro, HopsInCycle) {
  const auto laboratory = laboratory_of_rig("virtual-hard");
  ChamberPlant plant(laboratory.plant);
  ReducedGyro gyro(std::get<ReducedGyroParameters>(laboratory.body));
  const double step = std::get<ReducedGyroParameters>(laboratory.body).bias.mode_hops.step_deg_per_h;
  int hops = 0;
  double mode = 0;
  for (const double set_point_c : rate_cycle_c(1)) {
    gyro.step(plant.air(), plant.output_percent() / 100);
    plant.step({set_point_c}, true);
    const double now = gyro.bias_parts().mode_hops / step;
    if (now != std::round(now) || now == mode) continue;
    ++hops;
    mode = now;
  }
  EXPECT_GE(hops, 2);
  EXPECT_LE(hops, 4) << "one hop and its return in each warm phase";
}

TEST(HardGyro, EqualsLinearGyroWithoutHardTerms) {
  auto hard = reduced_of_rig("virtual-hard");
  const auto linear = reduced_of_rig("virtual");
  hard.cold = false;
  hard.bias.growth = {};
  hard.bias.lags = {};
  hard.bias.flow.unbalance_per_k = 0;
  hard.bias.relaxations.clear();
  hard.bias.warm_up.clear();
  hard.bias.plays = linear.bias.plays;
  hard.bias.mode_hops = {};
  hard.wind = {};
  hard.power_growth = {};
  ReducedGyro stripped(hard), plain(linear);
  for (int t = 0; t < 600; ++t) {
    stripped.step({20 + t / 20.0}, 0);
    plain.step({20 + t / 20.0}, 0);
    ASSERT_EQ(stripped.bias().value, plain.bias().value) << t;
  }
}

TEST(ColdStart, StartsAtAirTemperatureAndReachesRest) {
  auto cold = reduced_of_rig("virtual-hard");
  cold.start_c = -40;
  auto warm = cold;
  warm.cold = false;
  ReducedGyro gyro(cold);
  const ReducedGyro at_rest(warm);
  for (const double celsius : gyro.inner_c()) EXPECT_NEAR(celsius, -40, 1e-6);
  EXPECT_GT(at_rest.locations_c()[0], -39);
  for (int t = 0; t < 72000; ++t) gyro.step({-40}, 0);
  for (std::size_t i = 0; i < kThermalLocations; ++i)
    EXPECT_NEAR(gyro.locations_c()[i], at_rest.locations_c()[i], 0.01) << i;
}

TEST(ColdStart, StartsAtFirstSetPoint) {
  VirtualLaboratory laboratory(soak_at(laboratory_of_rig("virtual-hard"), {-40}), {});
  EXPECT_NEAR(laboratory.air_as_measured().value, -40, 0.06);
  for (const double shown_c : laboratory.thermometers_as_measured_c()) EXPECT_NEAR(shown_c, -40, 0.1);
  EXPECT_EQ(laboratory.set_point().value, -40);
}

/// An angle random walk N corresponds to white rate noise of 60 N over one second.
TEST(LockIn, RaisesAngleRandomWalkInCold) {
  const ReadoutParameters parameters{
      .arcsec_per_pulse = 1e-6, .angle_random_walk_deg_per_sqrt_h = 3e-4, .walk_growth = 0.35};
  for (const auto& [block_c, factor] : {std::pair(-40.0, 1.35), {20.0, 1.0}, {60.0, 1 - 0.35 * 40 / 60}}) {
    GyroReadout readout(parameters, 1);
    std::vector<double> rates;
    std::int64_t before = 0;
    for (int t = 0; t < 20000; ++t) {
      readout.step({}, {block_c});
      rates.push_back(1e-6 * static_cast<double>(readout.pulses() - before));
      before = readout.pulses();
    }
    EXPECT_NEAR(tests::standard_deviation(rates) / (60 * 3e-4), factor, 4 * factor / std::sqrt(4e4)) << block_c;
  }
}

double hourly_rate(const ReadoutParameters& parameters, double block_c) {
  GyroReadout readout(parameters, 1);
  for (int t = 0; t < 3600; ++t) readout.step({}, {block_c});
  return static_cast<double>(readout.pulses()) * parameters.arcsec_per_pulse / 3600;
}

TEST(ScaleFactor, ScalesEarthRate) {
  const ReadoutParameters parameters{.arcsec_per_pulse = 1e-6, .earth_rate_deg_per_h = 10.6, .scale_factor_ppm = 15};
  EXPECT_NEAR(hourly_rate(parameters, 60), 10.6 * (1 + 15e-6), 1e-9);
  EXPECT_NEAR(hourly_rate(parameters, 20), 10.6, 1e-9);
  EXPECT_NEAR(hourly_rate(parameters, -40), 10.6 * (1 - 22.5e-6), 1e-9);
}

TEST(Tilt, AddsCrosswiseEarthRate) {
  const ReadoutParameters parameters{
      .arcsec_per_pulse = 1e-6, .tilt_arcmin = 0.5, .crosswise_earth_rate_deg_per_h = 10.6};
  EXPECT_NEAR(hourly_rate(parameters, 60), 10.6 * std::sin(0.5 / 60 * std::numbers::pi / 180), 1e-9);
  EXPECT_NEAR(hourly_rate(parameters, 20), 0, 1e-9);
}

TEST(DeadBand, IsOffByDefault) {
  EXPECT_EQ(laboratory_of_rig("virtual").gyro.dead_band.half_width_deg_per_h, 0);
  EXPECT_EQ(half_width_deg_per_h({}, {-40}), 0);
  EXPECT_EQ(apply_lock_in({1e-9}, 0).value, 1e-9);
}

TEST(DeadBand, GrowsBelowSagTemperature) {
  const DeadBand band{.half_width_deg_per_h = 0.4, .sags_below_c = 10};
  for (const auto& [block_c, width] : {std::pair(60.0, 0.0), {10.0, 0.0}, {-15.0, 0.2}, {-40.0, 0.4}, {-45.0, 0.44}})
    EXPECT_NEAR(half_width_deg_per_h(band, {block_c}), width, 1e-15) << block_c;
}

TEST(DeadBand, ReducesRateByLockIn) {
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(apply_lock_in({sign * 0.2}, 0.3).value, 0);
    EXPECT_EQ(apply_lock_in({sign * 0.3}, 0.3).value, 0);
    EXPECT_DOUBLE_EQ(apply_lock_in({sign * 0.5}, 0.3).value, sign * 0.4);
    EXPECT_NEAR(apply_lock_in({sign * 10.6}, 0.3).value, sign * (10.6 - 0.3 * 0.3 / 2 / 10.6), 1e-5);
  }
}

TEST(DeadBand, AffectsReadoutOnlyInCold) {
  const ReadoutParameters parameters{.arcsec_per_pulse = 1e-6,
                                     .earth_rate_deg_per_h = 0.5,
                                     .dead_band = {.half_width_deg_per_h = 0.3, .sags_below_c = 0}};
  EXPECT_NEAR(hourly_rate(parameters, -40), 0.4, 1e-9);
  EXPECT_NEAR(hourly_rate(parameters, 20), 0.5, 1e-9);
}

/// On the shipped rig, the dead band reduces the measured Earth rate.
TEST(HardGyro, LosesTwoThousandthsInColdByDeadBand) {
  auto parameters = laboratory_of_rig("virtual-hard").gyro;
  parameters.arcsec_per_pulse = 1e-6;
  const double with = hourly_rate(parameters, -40);
  parameters.dead_band = {};
  EXPECT_NEAR(with - hourly_rate(parameters, -40), -0.2 * 0.2 / 2 / 10.6, 2e-5);
}

TEST(LostPulses, HaveRateOfFile) {
  GyroReadout readout({.arcsec_per_pulse = 0.1, .lost_pulses_per_h = 20}, 1);
  constexpr int kHours = 100;
  for (int t = 0; t < 3600 * kHours; ++t) readout.step({});
  EXPECT_NEAR(static_cast<double>(-readout.pulses()), 20 * kHours, 4 * std::sqrt(20.0 * kHours));
}

TEST(LostPulses, ReduceCountInEitherDirection) {
  constexpr int kHours = 20;
  for (const double earth_rate : {10.0, -10.0}) {
    const ReadoutParameters whole{.arcsec_per_pulse = 0.1, .earth_rate_deg_per_h = earth_rate};
    ReadoutParameters losing = whole;
    losing.lost_pulses_per_h = 20;
    GyroReadout without(whole, 1), with(losing, 1);
    for (int t = 0; t < 3600 * kHours; ++t) {
      without.step({});
      with.step({});
    }
    const auto lost = std::abs(without.pulses()) - std::abs(with.pulses());
    EXPECT_NEAR(static_cast<double>(lost), 20 * kHours, 4 * std::sqrt(20.0 * kHours)) << earth_rate;
  }
}

TEST(FailingThermometer, SticksOrOffsetsFromItsTime) {
  ThermometerParameters parameters;
  parameters.failing = {{.index = 2, .mode = FailureMode::stuck, .from_s = 10},
                        {.index = 3, .mode = FailureMode::offset, .from_s = 10, .error_k = 0.2}};
  ThermometerBank bank(parameters, places_at(0), 0);
  for (int t = 1; t <= 20; ++t) {
    bank.step(places_at(t));
    EXPECT_EQ(bank.readings_c()[0], t);
    EXPECT_EQ(bank.readings_c()[2], std::min(t, 10));
    EXPECT_DOUBLE_EQ(bank.readings_c()[3], t <= 10 ? t : t + 0.2);
  }
}

TEST(FailingThermometer, SpikesAreSingleReadings) {
  ThermometerParameters parameters;
  parameters.failing = {{.index = 0, .mode = FailureMode::spikes, .error_k = 5, .spikes_per_h = 36}};
  ThermometerBank bank(parameters, places_at(20), 0);
  int spikes = 0;
  constexpr int kHours = 20;
  for (int t = 0; t < 3600 * kHours; ++t) {
    bank.step(places_at(20));
    if (bank.readings_c()[0] == 20) continue;
    EXPECT_EQ(std::abs(bank.readings_c()[0] - 20), 5);
    ++spikes;
  }
  EXPECT_NEAR(spikes, 36 * kHours, 4 * std::sqrt(36.0 * kHours));
}

TEST(SelfHeating, GrowsWithResistanceOfPlatinum) {
  ThermometerParameters parameters;
  parameters.self_heating_k.fill(0.02);
  EXPECT_NEAR(ThermometerBank(parameters, places_at(20), 0).readings_c()[0], 20.02, 1e-12);
  EXPECT_NEAR(ThermometerBank(parameters, places_at(60), 0).readings_c()[0], 60 + 0.02 * 1.156332, 1e-9);
}

TEST(DrawGyro, DrawsTermsOfHardRig) {
  const auto type = laboratory_of_rig("virtual-hard");
  const auto& before = std::get<ReducedGyroParameters>(type.body);
  EXPECT_EQ(std::get<ReducedGyroParameters>(draw_gyro(type, 0).body).bias.growth.mirrors, before.bias.growth.mirrors);
  std::vector<double> gammas, logarithms, ageing, widths;
  int turned = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const auto drawn = draw_gyro(type, seed);
    const auto& after = std::get<ReducedGyroParameters>(drawn.body);
    gammas.insert(gammas.end(), after.bias.growth.mirrors.begin(), after.bias.growth.mirrors.end());
    ageing.insert(ageing.end(), after.ageing.mirrors.begin(), after.ageing.mirrors.end());
    for (std::size_t i = 0; i < 3; ++i) {
      const double factor = after.bias.relaxations[i].deg_per_h_per_k / before.bias.relaxations[i].deg_per_h_per_k;
      logarithms.push_back(std::log(std::abs(factor)));
      turned += factor < 0 ? 1 : 0;
    }
    EXPECT_LE(drawn.gyro.walk_growth, kMostWalkGrowth);
    widths.push_back(std::log(drawn.gyro.dead_band.half_width_deg_per_h / type.gyro.dead_band.half_width_deg_per_h));
  }
  EXPECT_NEAR(tests::standard_deviation(gammas) / 0.3, 1, 4 / std::sqrt(2.0 * 400));
  EXPECT_NEAR(tests::standard_deviation(ageing) / 0.03, 1, 4 / std::sqrt(2.0 * 400));
  EXPECT_NEAR(tests::standard_deviation(logarithms) / 0.35, 1, 4 / std::sqrt(2.0 * 300));
  EXPECT_NEAR(tests::standard_deviation(widths) / 0.35, 1, 4 / std::sqrt(2.0 * 100));
  EXPECT_NEAR(turned, 150, 4 * std::sqrt(75.0));
}

}  // namespace
}  // namespace gyrotherm::simulator
