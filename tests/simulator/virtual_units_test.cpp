// SPDX-License-Identifier: Apache-2.0
/// Tests a chamber with many units: the properties of each axis, and those that axes share.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/sha256.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "simulator/virtual_unit.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/simulator/small_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

UnitParameters unit_named(const std::string& name, const std::vector<std::string>& axes = {""}) {
  UnitParameters unit{.name = name, .axes = {}};
  for (const auto& axis : axes) unit.axes.push_back({.name = axis, .earth_rate_deg_per_h = 10});
  return unit;
}

/// Returns the default rig's type with a small body, in a chamber with constant air of 20 °C while it is switched off.
LaboratoryParameters small_laboratory(std::vector<UnitParameters> units) {
  auto world = laboratory_of_rig("virtual");
  auto& body = std::get<ReducedGyroParameters>(world.body);
  body.model = small_gyro();
  body.arms = {};
  world.plant.room_c = world.plant.start_c;
  world.units = std::move(units);
  return world;
}

/// Returns all output of one axis as text, one line per second.
std::string observed_output(VirtualLaboratory& laboratory, const std::string& unit, const std::string& axis,
                            int seconds) {
  const auto& names = laboratory.units();
  const auto u = static_cast<std::size_t>(std::ranges::find(names, unit) - names.begin());
  const auto& axes = laboratory.axes(u);
  const auto a = static_cast<std::size_t>(std::ranges::find(axes, axis) - axes.begin());
  const auto& channels = laboratory.thermometer_names();
  const auto first =
      static_cast<std::size_t>(std::ranges::find(channels, axis_name(axis_name(unit, axis), "A")) - channels.begin());
  std::string all;
  for (int t = 0; t < seconds; ++t) {
    laboratory.step();
    all += fmt::format("{} {} {}", laboratory.pulses(u)[a], laboratory.device_time_us(u),
                       laboratory.true_bias(u)[a].value);
    for (std::size_t i = 0; i < kThermalLocations; ++i)
      all += fmt::format(" {}", laboratory.thermometers_as_measured_c()[first + i]);
    for (const auto& value : laboratory.values(u)) all += fmt::format(" {} {}", value.name, value.value);
    all += '\n';
  }
  return all;
}

VirtualLaboratory cooling(const LaboratoryParameters& world, LaboratorySeed seed) {
  VirtualLaboratory laboratory(world, seed);
  laboratory.change_set_point({-10});
  laboratory.switch_on(true);
  return laboratory;
}

/// Returns the SHA-256 of all output of a laboratory without units while its gyro is switched off and turned around.
std::string output_hash(const std::string& rig, LaboratorySeed seed) {
  VirtualLaboratory laboratory(laboratory_of_rig(rig), seed);
  laboratory.change_set_point({40});
  laboratory.switch_on(true);
  std::string all;
  for (int t = 0; t < 3000; ++t) {
    if (t == 1000) laboratory.set_unit_state({.off = true});
    if (t == 1500) laboratory.set_unit_state({.turned = true});
    if (t == 2000) laboratory.change_set_point({-20});
    laboratory.step();
    all += fmt::format("{} {} {:f}", laboratory.pulses()[0], laboratory.device_time_us(),
                       laboratory.air_as_measured().value);
    for (const double celsius : laboratory.thermometers_as_measured_c()) all += fmt::format(" {:f}", celsius);
    all += '\n';
  }
  return sha256(all);
}

/// The hashes were recorded before rigs had units.
TEST(LaboratoryWithoutUnits, ReproducesRecordedHashes) {
  const std::map<std::string, std::pair<const char*, const char*>> worlds{
      {"virtual",
       {"b72a7deb89650439b02c9703c146081aea4a998fbafb858b8be600aec74fcbb3",
        "15bdcf043f4209d86eb74e3352e3e9c57cb3c87f9161edb4cdf5905a4e77a9de"}},
      {"virtual-hard",
       {"8783076a0f277bf8fe8d913107b5286630aedb9a5a95da0c18ad31b85c4c04c3",
        "b7361143602b8309c07bb6a6ec8b4c0deea9fe27716d4a272836713559fbbeaf"}},
      {"virtual-reference",
       {"f99077eec93b43a186ad18ff95e3f2bc7d021714848f8f9c91b0734d6623cfa1",
        "d9a9dd176dc2afb3ca3437475f41b5e63bb04f3af7f20ed980504a333db4d869"}},
      {"virtual-gradients",
       {"3c4b06e921c9f3b287a13ba156b73c59c45122ab59a25de434ec21b68ff6da7c",
        "1c8089e9aec6e3928d0c390bc99cfeab3c2109c9d1a88e6b0b9307595371ef89"}}};
  for (const auto& [rig, hashes] : worlds) {
    EXPECT_EQ(output_hash(rig, {.gyro = 0, .run = 7}), hashes.first) << rig;
    EXPECT_EQ(output_hash(rig, {.gyro = 3, .run = 7, .days_later = 30}), hashes.second) << rig;
  }
}

TEST(LaboratoryWithoutUnits, HasOneUnitWithOneAxis) {
  const VirtualLaboratory laboratory(laboratory_of_rig("virtual"), {});
  EXPECT_EQ(laboratory.units(), std::vector<std::string>{kPlainUnit});
  EXPECT_EQ(laboratory.axes(), std::vector<std::string>{""});
  EXPECT_EQ(laboratory.thermometer_names(),
            (std::vector<std::string>{"A", "B", "C", "D", "E", "F", "G", "H", "shell"}));
  EXPECT_TRUE(laboratory.values().empty());
}

TEST(VirtualUnits, NameThermometersAfterUnit) {
  const VirtualLaboratory laboratory(small_laboratory({unit_named("u1", {"x", "y"}), unit_named("solo")}), {});
  const auto& names = laboratory.thermometer_names();
  ASSERT_EQ(names.size(), 3 * kThermalLocations);
  EXPECT_EQ(names[0], "u1.x.A");
  EXPECT_EQ(names[8], "u1.x.shell");
  EXPECT_EQ(names[9], "u1.y.A");
  EXPECT_EQ(names[18], "solo.A");
  EXPECT_EQ(laboratory.thermometers_as_measured_c().size(), names.size());
}

/// Compares an axis with the same axis among others in another order, with the complete body of the default rig.
TEST(VirtualUnits, HaveAxesIndependentOfOtherUnits) {
  auto type = laboratory_of_rig("virtual");
  type.own_temperature = OwnThermometer{.time_constant_s = 30, .noise_k = 0.02};
  type.values = {{.name = "current", .at_20_c = 1, .per_k = 1e-3, .noise = 1e-3}};
  auto alone = type, among_others = type;
  alone.units = {unit_named("u2", {"y"})};
  among_others.units = {unit_named("u1", {"x", "y"}), unit_named("u2", {"y", "x"})};
  for (const std::uint64_t seed : {0U, 5U}) {
    auto one = cooling(alone, {.gyro = seed, .run = 2, .days_later = 3});
    auto lot = cooling(among_others, {.gyro = seed, .run = 2, .days_later = 3});
    EXPECT_EQ(observed_output(one, "u2", "y", 600), observed_output(lot, "u2", "y", 600)) << seed;
    EXPECT_EQ(one.air_as_measured(), lot.air_as_measured());
  }
}

TEST(VirtualUnits, AreReproducedBySeed) {
  const auto world = small_laboratory({unit_named("u1", {"x", "y"}), unit_named("u2")});
  for (const std::uint64_t seed : {0U, 1U}) {
    auto first = cooling(world, {.gyro = seed, .run = 1}), again = cooling(world, {.gyro = seed, .run = 1});
    EXPECT_EQ(observed_output(first, "u1", "y", 300), observed_output(again, "u1", "y", 300));
    auto other = cooling(world, {.gyro = seed, .run = 2});
    EXPECT_NE(observed_output(first, "u1", "y", 300), observed_output(other, "u1", "y", 300));
  }
}

/// Compares bodies, biases and noise of each pair of axes, also for seed 0.
TEST(VirtualUnits, HaveDifferentGyroForEachAxis) {
  for (const std::uint64_t seed : {0U, 1U}) {
    const auto world = small_laboratory({unit_named("u1", {"x", "y"}), unit_named("u2", {"x", "y"})});
    std::vector<std::string> seen;
    for (const auto* unit : {"u1", "u2"})
      for (const auto* axis : {"x", "y"}) {
        auto laboratory = cooling(world, {.gyro = seed});
        seen.push_back(observed_output(laboratory, unit, axis, 60));
      }
    std::ranges::sort(seen);
    EXPECT_EQ(std::ranges::adjacent_find(seen), seen.end());
  }
}

/// The hash is FNV-1a; its published value for "a" is expected. Other parts of a name that join to the same text give
/// another seed.
TEST(VirtualUnits, AreDrawnByName) {
  EXPECT_EQ(derive_seed({.gyro = 7}, "a").gyro, splitmix64(splitmix64(7) ^ 0xaf63dc4c8601ec8cU));
  EXPECT_NE(derive_seed({}, "u1.x").gyro, derive_seed({}, "u1x").gyro);
  EXPECT_EQ(derive_seed({.run = 3, .days_later = 4}, "a").run, 3U);
  EXPECT_EQ(derive_seed({.run = 3, .days_later = 4}, "a").days_later, 4U);
}

TEST(VirtualUnits, CountEarthRateOfEachAxis) {
  auto world = small_laboratory({unit_named("u", {"x", "y"})});
  world.units[0].axes[1].earth_rate_deg_per_h = -4;
  VirtualLaboratory laboratory(world, {});
  for (int t = 0; t < 3600; ++t) laboratory.step();
  for (std::size_t i = 0; i < 2; ++i) {
    const double rate = 0.1 * static_cast<double>(laboratory.pulses()[i]) / 3600;
    EXPECT_NEAR(rate, (i == 0 ? 10 : -4) + laboratory.true_bias()[i].value + laboratory.drift()[i].value, 0.004)
        << "except for noise and later drift";
  }
}

TEST(VirtualUnits, AreSwitchedAndTurnedTogether) {
  VirtualLaboratory laboratory(small_laboratory({unit_named("a"), unit_named("b")}), {});
  laboratory.set_unit_state({.off = true});
  for (int t = 0; t < 10; ++t) laboratory.step();
  for (const auto unit : {0U, 1U}) EXPECT_EQ(laboratory.pulses(unit)[0], 0);
  laboratory.set_unit_state({.turned = true});
  for (int t = 0; t < 100; ++t) laboratory.step();
  for (const auto unit : {0U, 1U}) EXPECT_LT(laboratory.pulses(unit)[0], -9000);
}

TEST(VirtualUnits, ContinueWhileSilent) {
  const auto world = small_laboratory({unit_named("a"), unit_named("b")});
  auto silenced = cooling(world, {}), speaking = cooling(world, {});
  silenced.silence(1, true);
  EXPECT_TRUE(silenced.is_silent(1));
  EXPECT_FALSE(silenced.is_silent(0));
  EXPECT_EQ(observed_output(silenced, "a", "", 100), observed_output(speaking, "a", "", 100));
  silenced.silence(1, false);
  EXPECT_EQ(observed_output(silenced, "b", "", 100), observed_output(speaking, "b", "", 100));
}

/// A hop affects output and drift, not the true bias. The other axis is unchanged.
TEST(OutputHop, DoesNotDependOnTemperature) {
  auto world = small_laboratory({unit_named("u", {"x", "y"})});
  auto hopping = world;
  hopping.units[0].axes[1].hop = OutputHop{.at_s = 100, .deg_per_h = 5, .for_s = 50};
  VirtualLaboratory plain(world, {}), hops(hopping, {});
  for (int t = 0; t < 200; ++t) {
    EXPECT_NEAR(hops.drift()[1].value - plain.drift()[1].value, t >= 100 && t < 150 ? 5 : 0, 1e-12) << t;
    plain.step();
    hops.step();
    EXPECT_EQ(hops.true_bias()[1], plain.true_bias()[1]);
    EXPECT_EQ(hops.pulses()[0], plain.pulses()[0]);
    const auto more = static_cast<double>(hops.pulses()[1] - plain.pulses()[1]);
    EXPECT_NEAR(0.1 * more, 5 * std::clamp(t - 99, 0, 50), 0.11) << t;
  }
}

TEST(OutputHop, IsPermanentWithoutDuration) {
  auto world = small_laboratory({unit_named("u")});
  world.units[0].axes[0].hop = OutputHop{.at_s = 3, .deg_per_h = 5};
  VirtualLaboratory hops(world, {});
  for (int t = 0; t < 3; ++t) hops.step();
  const double before = VirtualLaboratory(small_laboratory({unit_named("u")}), {}).drift()[0].value;
  EXPECT_NEAR(hops.drift()[0].value, before + 5, 0.1);
  for (int t = 0; t < 1000; ++t) hops.step();
  EXPECT_NEAR(hops.drift()[0].value, before + 5, 0.1);
}

TEST(OwnTemperature, FollowsBlockOfFirstAxis) {
  auto world = small_laboratory({unit_named("u", {"x", "y"}), unit_named("v")});
  world.own_temperature = OwnThermometer{.time_constant_s = 60, .noise_k = 0, .resolution_k = 0.5, .offset_k = 3};
  VirtualLaboratory laboratory(world, {});
  ASSERT_EQ(laboratory.values(0).size(), 1U);
  EXPECT_EQ(laboratory.values(0)[0].name, kOwnTemperature);
  for (const std::size_t unit : {0U, 1U}) {
    const double shown_c = laboratory.values(unit)[0].value;
    EXPECT_EQ(shown_c, round_to_resolution(shown_c, 0.5));
    double block_c = 0;
    const std::size_t first = unit == 0 ? 0 : 2 * kThermalLocations;
    for (std::size_t i = 0; i < kBlockLocations; ++i) block_c += laboratory.thermometers_as_measured_c()[first + i] / 8;
    EXPECT_NEAR(shown_c, block_c + 3, 0.25 + 0.1) << unit;
  }
}

TEST(OwnValues, AreLinearInBlockTemperature) {
  auto world = small_laboratory({unit_named("u")});
  world.own_temperature = OwnThermometer{};
  world.values = {{.name = "current", .at_20_c = 2, .per_k = 0.1, .noise = 0}, {.name = "voltage", .at_20_c = 5}};
  VirtualLaboratory laboratory(world, {});
  laboratory.change_set_point({60});
  laboratory.switch_on(true);
  for (int t = 0; t < 7200; ++t) laboratory.step();
  const auto values = laboratory.values();
  ASSERT_EQ(values.size(), 3U);
  EXPECT_GT(values[0].value, 40);
  EXPECT_NEAR(values[1].value, 2 + 0.1 * (values[0].value - 20), 0.01) << "the sensor lags by one second";
  EXPECT_EQ(values[2].value, 5);
}

TEST(DeadThermometer, ReadsNothingAfterFailure) {
  auto world = small_laboratory({unit_named("u", {"x", "y"})});
  world.units[0].axes[1].failing = {{.index = 3, .mode = FailureMode::dead, .from_s = 10}};
  VirtualLaboratory laboratory(world, {});
  for (int t = 1; t <= 20; ++t) {
    laboratory.step();
    for (std::size_t i = 0; i < 2 * kThermalLocations; ++i)
      EXPECT_EQ(std::isnan(laboratory.thermometers_as_measured_c()[i]), i == kThermalLocations + 3 && t > 10) << t;
  }
}

TEST(VirtualUnits, CanExchangeThermometers) {
  VirtualLaboratory laboratory(small_laboratory({unit_named("a"), unit_named("b")}), {});
  const auto now = laboratory.thermometers_as_measured_c();
  const std::vector<double> sound(now.begin(), now.end());
  LaboratoryFaults faults(sound.size());
  std::swap(faults.thermometers[0].location, faults.thermometers[kThermalLocations].location);
  faults.thermometers[12].error_k = 2;
  laboratory.inject(faults);
  EXPECT_EQ(laboratory.thermometers_as_measured_c()[0], sound[kThermalLocations]);
  EXPECT_EQ(laboratory.thermometers_as_measured_c()[kThermalLocations], sound[0]);
  EXPECT_EQ(laboratory.thermometers_as_measured_c()[12], sound[12] + 2);
  laboratory.inject({});
  EXPECT_EQ(laboratory.thermometers_as_measured_c()[0], sound[0]);
}

}  // namespace
}  // namespace gyrotherm::simulator
