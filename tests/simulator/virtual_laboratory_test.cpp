// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_laboratory.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/sha256.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/thermometer_bank.hpp"
#include "tests/simulator/shipped_rigs.hpp"

namespace gyrotherm::simulator {
namespace {

/// Returns all values that instruments can read, after each second on the way to a set point.
std::vector<double> observed_values(VirtualLaboratory& laboratory, Celsius set_point, int seconds) {
  std::vector<double> all;
  laboratory.change_set_point(set_point);
  laboratory.switch_on(true);
  for (int t = 0; t < seconds; ++t) {
    laboratory.step();
    all.push_back(laboratory.air_as_measured().value);
    all.push_back(laboratory.output_percent());
    all.push_back(static_cast<double>(laboratory.pulses()[0]));
    all.push_back(static_cast<double>(laboratory.device_time_us()));
    for (const double reading : laboratory.thermometers_as_measured_c()) all.push_back(reading);
  }
  return all;
}

constexpr std::array kRigs{"virtual", "virtual-reference"};

std::vector<double> seen_with_seed(const std::string& rig, std::uint64_t seed) {
  VirtualLaboratory laboratory(laboratory_of_rig(rig), {.gyro = seed, .run = 0});
  return observed_values(laboratory, {-10}, 600);
}

TEST(VirtualLaboratory, IsReproducedBySeedAndSetPoints) {
  for (const auto* rig : kRigs)
    for (const std::uint64_t seed : {0U, 1U, 12345U})
      EXPECT_EQ(seen_with_seed(rig, seed), seen_with_seed(rig, seed)) << rig << ' ' << seed;
}

/// Returns the mean rate over `seconds`, °/h. 1 arcsec/s equals 1 °/h.
double rate_over(VirtualLaboratory& laboratory, int seconds) {
  const auto before = laboratory.pulses()[0];
  for (int t = 0; t < seconds; ++t) laboratory.step();
  return laboratory.arcsec_per_pulse() * static_cast<double>(laboratory.pulses()[0] - before) / seconds;
}

TEST(VirtualLaboratory, MeasuresOppositeEarthRateWithTurnedGyro) {
  for (const auto* rig : kRigs) {
    VirtualLaboratory laboratory(laboratory_of_rig(rig), {.gyro = 1, .run = 0});
    laboratory.change_set_point({20});
    laboratory.switch_on(true);
    const double as_mounted = rate_over(laboratory, 600);
    laboratory.set_unit_state({.turned = true});
    const double turned = rate_over(laboratory, 600);
    const double earth_rate = 15.041067 * std::sin(45 * std::numbers::pi / 180);
    EXPECT_NEAR((as_mounted - turned) / 2, earth_rate, 0.01) << rig << ": tolerance for noise over ten minutes";
    EXPECT_NEAR((as_mounted + turned) / 2, laboratory.true_bias()[0].value + laboratory.drift()[0].value, 0.02) << rig;
    laboratory.set_unit_state({});
    EXPECT_NEAR(rate_over(laboratory, 600), as_mounted, 0.02) << rig;
  }
}

TEST(VirtualLaboratory, SilencesAndCoolsGyroThatIsSwitchedOff) {
  for (const auto* rig : kRigs) {
    VirtualLaboratory laboratory(laboratory_of_rig(rig), {.gyro = 1, .run = 0});
    laboratory.change_set_point({20});
    laboratory.switch_on(true);
    const double warm_c = laboratory.thermometers_as_measured_c()[0];
    laboratory.set_unit_state({.off = true});
    const auto pulses = laboratory.pulses()[0];
    for (int t = 0; t < 8 * 3600; ++t) laboratory.step();
    EXPECT_EQ(laboratory.pulses()[0], pulses) << rig;
    EXPECT_NEAR(laboratory.thermometers_as_measured_c()[0], 20, 0.3) << rig;
    EXPECT_GT(warm_c, 21) << rig;
    laboratory.set_unit_state({});
    for (int t = 0; t < 8 * 3600; ++t) laboratory.step();
    EXPECT_GT(laboratory.pulses()[0], pulses) << rig;
    EXPECT_NEAR(laboratory.thermometers_as_measured_c()[0], warm_c, 0.3) << rig;
  }
}

/// The hard gyro draws a new turn-on offset, and its warm-up begins again.
TEST(VirtualLaboratory, RestartsGyroWhenSwitchedOnAgain) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual-hard"), {.gyro = 1, .run = 0});
  laboratory.change_set_point({20});
  laboratory.switch_on(true);
  for (int t = 0; t < 10; ++t) laboratory.step();
  const double before = laboratory.drift()[0].value;
  laboratory.set_unit_state({.off = true});
  laboratory.step();
  EXPECT_EQ(laboratory.drift()[0].value, before) << "no drift while it is off";
  laboratory.set_unit_state({});
  EXPECT_NE(laboratory.drift()[0].value, before);
  EXPECT_NEAR(laboratory.drift()[0].value, before, 0.02);
}

TEST(VirtualLaboratory, DiffersBySeed) {
  for (const auto* rig : kRigs) {
    EXPECT_NE(seen_with_seed(rig, 0), seen_with_seed(rig, 1)) << rig;
    EXPECT_NE(seen_with_seed(rig, 1), seen_with_seed(rig, 2)) << rig;
  }
}

/// Returns the SHA-256 of the first thousand pulse counts, one per line, on the way to 40 °C.
std::string first_pulses_hash(std::uint64_t seed) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {.gyro = seed, .run = 0});
  laboratory.change_set_point({40});
  laboratory.switch_on(true);
  std::string counts;
  for (int t = 0; t < 1000; ++t) {
    laboratory.step();
    counts += std::to_string(laboratory.pulses()[0]) + '\n';
  }
  return sha256(counts);
}

/// The recorded pulses predate the optional terms of a rig file, which must not affect a rig without them.
TEST(VirtualLaboratory, ReproducesRecordedPulsesOfLinearRig) {
  EXPECT_EQ(first_pulses_hash(0), "9a33b264f2d13e730c9fbf544d3646e960b241a2a897333f392a6c603f34d034");
  EXPECT_EQ(first_pulses_hash(3), "3b87a6c7867e2a76d77ed2897b7f3dd74756f6c6df9c9065d9f9f8edbce0741c");
}

TEST(VirtualLaboratory, DrawsIndependentNoiseForEachRun) {
  VirtualLaboratory first(laboratory_of_rig("virtual"), {.gyro = 1, .run = 1});
  VirtualLaboratory second(laboratory_of_rig("virtual"), {.gyro = 1, .run = 2});
  for (int i = 0; i < 100; ++i) {
    first.step();
    second.step();
  }
  EXPECT_NE(first.pulses()[0], second.pulses()[0]);
  EXPECT_NEAR(static_cast<double>(first.pulses()[0]), static_cast<double>(second.pulses()[0]), 10)
      << "the bias is the same";
}

TEST(VirtualLaboratory, IsUnchangedByReading) {
  VirtualLaboratory read(laboratory_of_rig("virtual"), {.gyro = 3, .run = 0});
  VirtualLaboratory unread(laboratory_of_rig("virtual"), {.gyro = 3, .run = 0});
  (void)observed_values(read, {30}, 100);
  unread.change_set_point({30});
  unread.switch_on(true);
  for (int t = 0; t < 100; ++t) unread.step();
  EXPECT_EQ(observed_values(read, {30}, 10), observed_values(unread, {30}, 10));
}

TEST(VirtualLaboratory, StartsAtRestAndSwitchedOff) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual-reference"), {.gyro = 0, .run = 0});
  EXPECT_FALSE(laboratory.is_on());
  EXPECT_EQ(laboratory.set_point().value, 20);
  EXPECT_EQ(laboratory.pulses()[0], 0);
  EXPECT_NEAR(laboratory.air_as_measured().value, 20, 0.06);
  EXPECT_NEAR(laboratory.thermometers_as_measured_c()[0], 23.297, 0.06);
  EXPECT_NEAR(laboratory.thermometers_as_measured_c()[8], 20.960, 0.06);
}

TEST(VirtualLaboratory, RefusesSetPointsOutsidePlantRange) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {.gyro = 0, .run = 0});
  EXPECT_TRUE(laboratory.accepts({-45}));
  EXPECT_TRUE(laboratory.accepts({90}));
  EXPECT_FALSE(laboratory.accepts({-45.1}));
  EXPECT_FALSE(laboratory.accepts({std::nan("")}));
}

TEST(VirtualLaboratory, CountsEarthRateAndBias) {
  for (const auto* rig : kRigs) {
    const auto parameters = laboratory_of_rig(rig);
    VirtualLaboratory laboratory(parameters, {});
    (void)observed_values(laboratory, {20}, 3600);
    const double arcsec = static_cast<double>(laboratory.pulses()[0]) * parameters.gyro.arcsec_per_pulse;
    EXPECT_NEAR(arcsec / 3600,
                parameters.gyro.earth_rate_deg_per_h + (laboratory.true_bias()[0] + laboratory.drift()[0]).value, 0.002)
        << rig;
  }
}

TEST(DrawGyro, KeepsGyroOfFileForSeedZero) {
  const auto type = laboratory_of_rig("virtual-reference");
  const auto drawn = draw_gyro(type, 0);
  const auto& before = std::get<LumpedGyroParameters>(type.body);
  const auto& after = std::get<LumpedGyroParameters>(drawn.body);
  EXPECT_EQ(after.network.capacity_j_per_k, before.network.capacity_j_per_k);
  EXPECT_EQ(after.network.film_w_per_k, before.network.film_w_per_k);
  EXPECT_EQ(after.bias.gradient_deg_per_h_per_k, before.bias.gradient_deg_per_h_per_k);
  EXPECT_EQ(drawn.thermometers.offset_k, type.thermometers.offset_k);
}

TEST(DrawGyro, VariesGyrosOfOtherSeeds) {
  const auto type = laboratory_of_rig("virtual-reference");
  const auto& before = std::get<LumpedGyroParameters>(type.body);
  double sum = 0;
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    const auto drawn = draw_gyro(type, seed);
    const auto& after = std::get<LumpedGyroParameters>(drawn.body);
    EXPECT_NE(drawn.thermometers.offset_k[0], 0);
    EXPECT_NE(after.bias.arm_deg_per_h_per_k, before.bias.arm_deg_per_h_per_k);
    for (std::size_t i = 0; i < before.network.nodes.size(); ++i, ++count) {
      const double logarithm = std::log(after.network.capacity_j_per_k[i] / before.network.capacity_j_per_k[i]);
      sum += logarithm;
      squares += logarithm * logarithm;
    }
  }
  EXPECT_NEAR(sum / count, 0, 4 * 0.15 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.15, 4 * 0.15 / std::sqrt(2.0 * count));
}

/// Returns the air temperature after `minutes` on the way to `set_point`.
double air_after(VirtualLaboratory& laboratory, Celsius set_point, int minutes) {
  laboratory.change_set_point(set_point);
  laboratory.switch_on(true);
  for (int t = 0; t < 60 * minutes; ++t) laboratory.step();
  return laboratory.air_as_measured().value;
}

TEST(VirtualLaboratory, DoesNotHeatWithoutHeaterAndWarmsWithOpenDoor) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual-reference"), {});
  LaboratoryFaults faults;
  faults.plant.heating_share = 0;
  laboratory.inject(faults);
  EXPECT_LT(air_after(laboratory, {60}, 20), 22);
  laboratory.inject({});
  EXPECT_NEAR(air_after(laboratory, {60}, 20), 60, 1);
  faults = {};
  faults.plant.door_open = true;
  laboratory.inject(faults);
  EXPECT_LT(air_after(laboratory, {60}, 20), 50);
}

TEST(VirtualLaboratory, RunsAwayWithStuckMachineryOrWrongSensor) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual-reference"), {});
  LaboratoryFaults faults;
  faults.plant.stuck_output = 1;
  laboratory.inject(faults);
  EXPECT_GT(air_after(laboratory, {20}, 20), 90);
  VirtualLaboratory frozen(laboratory_of_rig("virtual-reference"), {});
  faults = {};
  faults.plant.sensor_c = 20;
  frozen.inject(faults);
  EXPECT_NEAR(air_after(frozen, {40}, 5), 20, 0.05) << "the reading is frozen except for noise";
  frozen.inject({});
  EXPECT_GT(frozen.output_percent(), 50);
  frozen.step();
  EXPECT_GT(frozen.air_as_measured().value, 50) << "the real air temperature continued to rise";
}

TEST(VirtualLaboratory, AppliesAndRemovesThermometerFaults) {
  VirtualLaboratory laboratory(laboratory_of_rig("virtual-reference"), {});
  const auto sound =
      std::vector(laboratory.thermometers_as_measured_c().begin(), laboratory.thermometers_as_measured_c().end());
  LaboratoryFaults faults;
  faults.thermometers[0].shown_c = 850;
  faults.thermometers[1].error_k = 2;
  std::swap(faults.thermometers[2].location, faults.thermometers[8].location);
  laboratory.inject(faults);
  const auto shown = laboratory.thermometers_as_measured_c();
  EXPECT_EQ(shown[0], 850);
  EXPECT_EQ(shown[1], sound[1] + 2);
  EXPECT_EQ(shown[2], sound[8]);
  EXPECT_EQ(shown[8], sound[2]);
  laboratory.inject({});
  for (std::size_t i = 0; i < sound.size(); ++i) EXPECT_EQ(laboratory.thermometers_as_measured_c()[i], sound[i]);
}

}  // namespace
}  // namespace gyrotherm::simulator
