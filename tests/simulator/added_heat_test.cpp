// SPDX-License-Identifier: Apache-2.0
/// Tests the side wind, the temperature-dependent powers, the bracket, and their effect on the bias.
#include "simulator/added_heat.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <string>

#include "simulator/chamber_plant.hpp"
#include "simulator/thermometer_bank.hpp"
#include "simulator/virtual_gyro.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/simulator/small_gyro.hpp"
#include "tests/support/statistics.hpp"

namespace gyrotherm::simulator {
namespace {

using thermal::ThermalInput;
using thermal::ThermalOutput;
using InnerC = std::array<double, thermal::kThermalOutputs>;

constexpr thermal::ThermalPowers kPowersW{0.3, 0.28, 0.8, 0.07, 0.06};
constexpr SideWind kWind{
    .steady = 0.1, .heating = 0.1, .cooling = -0.2, .share = 0.2, .time_constant_s = 50, .gap_w_per_k = 0.04};
constexpr PowerGrowth kGrowth{
    .gain_per_k = 5e-4, .preamplifier_per_k = -1e-3, .ballast_per_k = 1e-4, .split_per_k = 3e-4};

double power_w(const thermal::ThermalPowers& powers_w, ThermalInput input) {
  return powers_w[static_cast<std::size_t>(input) - 1];
}

InnerC uniform_temperatures(double celsius) {
  InnerC inner{};
  inner.fill(celsius);
  return inner;
}

/// Returns the heat that the wind adds to the left gain arm after `seconds` at this heater output.
double wind_w(double output, int seconds) {
  AddedHeat heat(kPowersW, kWind, {});
  for (int t = 0; t < seconds; ++t) heat.follow({60}, 20, output);
  return power_w(heat.watts(uniform_temperatures(20)), ThermalInput::gain_left);
}

TEST(AddedHeat, IsZeroByDefault) {
  EXPECT_FALSE(AddedHeat(kPowersW, {}, {}).has_effect());
  EXPECT_EQ(AddedHeat(kPowersW, {}, {}).watts(uniform_temperatures(60)), thermal::ThermalPowers{});
  const auto linear = reduced_of_rig("virtual");
  EXPECT_FALSE(AddedHeat(linear.model.powers_w, linear.wind, linear.power_growth).has_effect());
  const auto hard = reduced_of_rig("virtual-hard");
  EXPECT_TRUE(AddedHeat(hard.model.powers_w, hard.wind, {}).has_effect());
  EXPECT_TRUE(AddedHeat(hard.model.powers_w, {}, hard.power_growth).has_effect());
}

TEST(SideWind, SeparatesHalvesWithTimeConstant) {
  const double parted_k = 0.2 * (0.1 + 0.1) * 40;
  EXPECT_NEAR(wind_w(1, 50), 0.04 / 2 * parted_k * (1 - std::exp(-1)), 1e-12);
  EXPECT_NEAR(wind_w(1, 5000), 0.04 / 2 * parted_k, 1e-12);
}

TEST(SideWind, ChangesWithHeaterAndCooler) {
  for (const auto& [output, wind] : {std::pair(1.0, 0.2), {0.5, 0.15}, {0.0, 0.1}, {-0.5, 0.0}, {-1.0, -0.1}})
    EXPECT_NEAR(wind_w(output, 5000), 0.04 / 2 * 0.2 * wind * 40, 1e-12) << output;
}

TEST(SideWind, RemovesFromRightWhatItAddsToLeft) {
  AddedHeat heat(kPowersW, kWind, {});
  heat.follow({60}, 20, 1);
  const auto added_w = heat.watts(uniform_temperatures(35));
  EXPECT_GT(power_w(added_w, ThermalInput::gain_left), 0);
  EXPECT_EQ(power_w(added_w, ThermalInput::ballast_left), power_w(added_w, ThermalInput::gain_left));
  EXPECT_EQ(power_w(added_w, ThermalInput::gain_right), -power_w(added_w, ThermalInput::gain_left));
  EXPECT_EQ(power_w(added_w, ThermalInput::ballast_right), -power_w(added_w, ThermalInput::ballast_left));
  EXPECT_EQ(power_w(added_w, ThermalInput::preamplifier), 0);
}

TEST(PowerGrowth, IsProportionalToSourceTemperature) {
  auto inner_c = uniform_temperatures(50);
  inner_c[static_cast<std::size_t>(ThermalOutput::gain_left)] = 60;
  inner_c[static_cast<std::size_t>(ThermalOutput::gain_right)] = 58;
  inner_c[static_cast<std::size_t>(ThermalOutput::preamplifier)] = -30;
  AddedHeat heat(kPowersW, {}, kGrowth);
  const auto added_w = heat.watts(inner_c);
  const double over_w = 3e-4 * 30 * (0.3 + 0.28) / 2;
  EXPECT_NEAR(power_w(added_w, ThermalInput::gain_left), 0.3 * 5e-4 * 40 + over_w, 1e-15);
  EXPECT_NEAR(power_w(added_w, ThermalInput::gain_right), 0.28 * 5e-4 * 38 - over_w, 1e-15);
  EXPECT_NEAR(power_w(added_w, ThermalInput::preamplifier), 0.8 * 1e-3 * 50, 1e-15);
  EXPECT_NEAR(power_w(added_w, ThermalInput::ballast_left), 0.07 * 1e-4 * 30, 1e-15);
  EXPECT_NEAR(power_w(added_w, ThermalInput::ballast_right), 0.06 * 1e-4 * 30, 1e-15);
  EXPECT_EQ(heat.watts(uniform_temperatures(20)), thermal::ThermalPowers{})
      << "the powers of the file are valid at 20 °C";
  heat.switch_on(false);
  EXPECT_EQ(heat.watts(inner_c), thermal::ThermalPowers{}) << "without power there is no growth";
}

ReducedGyroParameters gyro_with_wind() {
  ReducedGyroParameters type;
  type.model = small_gyro();
  type.start_c = -10;
  type.film = thermal::GyroFilm::chamber;
  type.bias.mirror_deg_per_h_per_k = {5e-3, -4e-3, 3e-3, 6e-3};
  type.wind = kWind;
  type.power_growth = kGrowth;
  return type;
}

TEST(AddedHeat, StaysAtRestWithGyro) {
  ReducedGyro gyro(gyro_with_wind());
  const InnerC rest_c = [&] {
    InnerC inner{};
    std::ranges::copy(gyro.inner_c(), inner.begin());
    return inner;
  }();
  EXPECT_NE(gyro.inner_c()[1], gyro.inner_c()[2]) << "left and right differ";
  for (int t = 0; t < 3600; ++t) gyro.step({-10}, 0);
  for (std::size_t i = 0; i < rest_c.size(); ++i) EXPECT_NEAR(gyro.inner_c()[i], rest_c[i], 1e-6) << i;
}

/// At rest, the heat through the film equals the sum of all sources. The sum of the wind's contributions is 0.
TEST(AddedHeat, FlowsThroughFilmAtRest) {
  auto type = gyro_with_wind();
  const double shell_c = ReducedGyro(type).locations_c()[8];
  const auto inner_c = [&] {
    InnerC inner{};
    std::ranges::copy(ReducedGyro(type).inner_c(), inner.begin());
    return inner;
  }();
  const auto grown_w = AddedHeat(type.model.powers_w, {}, kGrowth).watts(inner_c);
  const double sum_w = std::accumulate(grown_w.begin(), grown_w.end(), 0.0);
  const double given_w = std::accumulate(type.model.powers_w.begin(), type.model.powers_w.end(), 0.0);
  EXPECT_NEAR((shell_c + 10) * 25 * 0.09, given_w + sum_w, 1e-6) << "film coefficient times area of the small gyro";
}

/// Returns the linear gyro with this side wind and power growth, but no other terms of the hard gyro.
ReducedGyroParameters linear_with(const SideWind& wind, const PowerGrowth& growth) {
  auto gyro = reduced_of_rig("virtual");
  gyro.wind = wind;
  gyro.power_growth = growth;
  return gyro;
}

/// Returns the true bias in each second of the cycle at 5 °C/min, in the air of the simulated chamber.
std::vector<double> fast_cycle(const ReducedGyroParameters& parameters) {
  ChamberPlant plant(laboratory_of_rig("virtual-hard").plant);
  ReducedGyro gyro(parameters);
  std::vector<double> bias;
  for (const double set_point_c : rate_cycle_c(5)) {
    gyro.step(plant.air(), plant.output_percent() / 100);
    plant.step({set_point_c}, true);
    bias.push_back(gyro.bias().value);
  }
  return bias;
}

/// RMS and greatest magnitude of the difference between two biases, °/h.
struct Difference {
  double rms{}, greatest{};
};

Difference difference(const std::vector<double>& a, const std::vector<double>& b) {
  Difference found;
  for (std::size_t i = 0; i < a.size(); ++i) {
    found.rms += (a[i] - b[i]) * (a[i] - b[i]) / static_cast<double>(a.size());
    found.greatest = std::max(found.greatest, std::abs(a[i] - b[i]));
  }
  found.rms = std::sqrt(found.rms);
  return found;
}

TEST(HardGyro, SideWindChangesBias) {
  const auto moved =
      difference(fast_cycle(linear_with(reduced_of_rig("virtual-hard").wind, {})), fast_cycle(linear_with({}, {})));
  EXPECT_NEAR(moved.rms, 1.3e-3, 2e-4);
  EXPECT_NEAR(moved.greatest, 4.8e-3, 5e-4);
}

TEST(HardGyro, PowerGrowthChangesBias) {
  const auto moved = difference(fast_cycle(linear_with({}, reduced_of_rig("virtual-hard").power_growth)),
                                fast_cycle(linear_with({}, {})));
  EXPECT_NEAR(moved.rms, 1.2e-3, 2e-4);
  EXPECT_NEAR(moved.greatest, 2e-3, 3e-4);
}

/// The air temperature is the same in both cases. In one case the heater produces it, in the other the cooler.
TEST(HardGyro, HasDifferentGradientsWhenCooledAndHeated) {
  const auto gyro = linear_with(reduced_of_rig("virtual-hard").wind, {});
  ReducedGyro heated(gyro), cooled(gyro);
  for (int t = 0; t < 1200; ++t) {
    heated.step({20 + t / 30.0}, 1);
    cooled.step({20 + t / 30.0}, -1);
  }
  const auto arms_k = [](const ReducedGyro& one) {
    return one.inner_c()[static_cast<std::size_t>(ThermalOutput::gain_left)] -
           one.inner_c()[static_cast<std::size_t>(ThermalOutput::gain_right)];
  };
  EXPECT_NEAR(arms_k(heated) - arms_k(cooled), 0.2, 0.02);
  EXPECT_NEAR(heated.bias().value - cooled.bias().value, 3.7e-3, 4e-4);
}

TEST(DrawGyro, DrawsWindAndPowersWithinLimits) {
  const auto type = laboratory_of_rig("virtual-hard");
  const auto& before = std::get<ReducedGyroParameters>(type.body);
  std::vector<double> logarithms;
  int turned = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const auto drawn = draw_gyro(type, seed);
    const auto& after = std::get<ReducedGyroParameters>(drawn.body);
    for (const double wind : {after.wind.steady, after.wind.heating, after.wind.cooling})
      EXPECT_LE(std::abs(wind), kMostWind);
    EXPECT_EQ(after.wind.gap_w_per_k, before.wind.gap_w_per_k);
    for (const double factor : {after.power_growth.gain_per_k / before.power_growth.gain_per_k,
                                after.power_growth.split_per_k / before.power_growth.split_per_k}) {
      logarithms.push_back(std::log(std::abs(factor)));
      turned += factor < 0 ? 1 : 0;
    }
  }
  EXPECT_NEAR(tests::standard_deviation(logarithms) / 0.35, 1, 4 / std::sqrt(2.0 * 400));
  EXPECT_NEAR(turned, 200, 4 * std::sqrt(100.0));
}

constexpr BracketParameters kFirst{.units = {}, .share = 0.3, .time_constant_s = 600};

/// Returns a laboratory with these units on these brackets, in air of constant 20 °C. Each unit has one axis and exact
/// thermometers; the powers of the units differ widely.
LaboratoryParameters laboratory_with_brackets(const std::vector<std::string>& units,
                                              std::vector<BracketParameters> brackets) {
  auto world = laboratory_of_rig("virtual");
  auto& body = std::get<ReducedGyroParameters>(world.body);
  body.model = small_gyro();
  body.arms = {};
  body.spread.power = 0.5;
  world.plant.room_c = world.plant.start_c;
  world.thermometers = {};
  world.spread.offset_k = world.spread.gain = 0;
  for (const auto& name : units) world.units.push_back({.name = name, .axes = {{.earth_rate_deg_per_h = 10}}});
  world.brackets = std::move(brackets);
  return world;
}

BracketParameters with(BracketParameters bracket, std::vector<std::size_t> units) {
  bracket.units = std::move(units);
  return bracket;
}

std::map<std::string, double> thermometers(const VirtualLaboratory& laboratory) {
  std::map<std::string, double> shown_c;
  for (std::size_t i = 0; i < laboratory.thermometer_names().size(); ++i)
    shown_c[laboratory.thermometer_names()[i]] = laboratory.thermometers_as_measured_c()[i];
  return shown_c;
}

TEST(Bracket, FollowsCabinetsWithTimeConstant) {
  Bracket bracket(kFirst, {20});
  for (int t = 0; t < 600; ++t) bracket.follow({30});
  EXPECT_NEAR(bracket.temperature().value, 30 - 10 * std::exp(-1), 1e-9);
  EXPECT_NEAR(bracket.effective_air({10}).value, 10 + 0.3 * (bracket.temperature().value - 10), 1e-12);
}

/// The cabinet is 2 K warmer than its effective air at 20 °C. The difference grows by 1 % per 10 K.
TEST(Bracket, RestsConsistentlyWithCabinets) {
  const auto cabinets = [](Celsius seen) { return Celsius{seen.value + 2 + 0.002 * (seen.value - 20)}; };
  for (const double share : {0.0, 0.3, kMostBracketShare}) {
    const auto rests = bracket_at_rest(share, {-40}, cabinets);
    EXPECT_NEAR(rests.value, cabinets({-40 + share * (rests.value + 40)}).value, 1e-8) << share;
  }
}

TEST(Bracket, StaysAtRestWithBodies) {
  auto world = laboratory_with_brackets({"a", "b", "c"}, {with(kFirst, {0, 1, 2})});
  VirtualLaboratory laboratory(world, {.gyro = 1});
  const auto before = thermometers(laboratory);
  const double rests_c = laboratory.bracket(0)->value;
  for (int t = 0; t < 3 * 3600; ++t) laboratory.step();
  EXPECT_NEAR(laboratory.bracket(0)->value, rests_c, 1e-6);
  for (const auto& [name, celsius] : thermometers(laboratory)) EXPECT_NEAR(celsius, before.at(name), 1e-6) << name;
}

/// Cold bodies and their bracket start at the temperature of the air.
TEST(Bracket, StartsAtAirTemperatureForColdBodies) {
  auto world = laboratory_with_brackets({"a", "b"}, {with(kFirst, {0, 1})});
  std::get<ReducedGyroParameters>(world.body).cold = true;
  const VirtualLaboratory laboratory(world, {.gyro = 1});
  EXPECT_NEAR(laboratory.bracket(1)->value, 20, 1e-6);
  for (const auto& [name, celsius] : thermometers(laboratory)) EXPECT_NEAR(celsius, 20, 1e-6) << name;
}

/// Compares two bodies on separate brackets with the same bodies on a common bracket, where the warmer one heats the
/// other.
TEST(Bracket, TransfersHeatBetweenBodies) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const VirtualLaboratory separate(laboratory_with_brackets({"a", "b"}, {with(kFirst, {0}), with(kFirst, {1})}),
                                     {.gyro = seed});
    const VirtualLaboratory together(laboratory_with_brackets({"a", "b"}, {with(kFirst, {0, 1})}), {.gyro = seed});
    const VirtualLaboratory alone(laboratory_with_brackets({"a", "b"}, {}), {.gyro = seed});
    EXPECT_FALSE(alone.bracket(0));
    auto own = thermometers(separate), shared = thermometers(together), bare = thermometers(alone);
    const std::string warm = own["a.shell"] > own["b.shell"] ? "a" : "b";
    const std::string other = warm == "a" ? "b" : "a";
    ASSERT_GT(own[warm + ".shell"], own[other + ".shell"] + 0.01) << "the powers of the bodies differ";
    for (const auto* place : {".A", ".shell"}) {
      const double lost_k = own[warm + place] - shared[warm + place];
      const double gained_k = shared[other + place] - own[other + place];
      EXPECT_GT(lost_k, 0) << place;
      EXPECT_NEAR(gained_k, lost_k, 0.1 * lost_k) << place << ": heat is conserved except through the films";
      EXPECT_GT(shared[other + place], bare[other + place]) << "warmer than without a bracket";
    }
    EXPECT_GT(together.bracket(0)->value, shared[other + ".shell"]);
    EXPECT_LT(together.bracket(0)->value, shared[warm + ".shell"]);
  }
}

TEST(Bracket, DoesNotDependOnOrderOfUnits) {
  VirtualLaboratory ab(laboratory_with_brackets({"a", "b"}, {with(kFirst, {0, 1})}), {.gyro = 2});
  VirtualLaboratory ba(laboratory_with_brackets({"b", "a"}, {with(kFirst, {1, 0})}), {.gyro = 2});
  for (auto* laboratory : {&ab, &ba}) {
    laboratory->change_set_point({-20});
    laboratory->switch_on(true);
    for (int t = 0; t < 1800; ++t) laboratory->step();
  }
  EXPECT_EQ(thermometers(ab), thermometers(ba));
}

/// After a change of the air, the cabinets follow the air and the bracket follows the cabinets.
TEST(Bracket, LagsBehindBodies) {
  VirtualLaboratory laboratory(laboratory_with_brackets({"a", "b"}, {with(kFirst, {0, 1})}), {.gyro = 1});
  laboratory.change_set_point({60});
  laboratory.switch_on(true);
  for (int t = 0; t < 900; ++t) laboratory.step();
  const auto shown = thermometers(laboratory);
  const double cabinets_c = (shown.at("a.shell") + shown.at("b.shell")) / 2;
  EXPECT_LT(laboratory.bracket(0)->value, cabinets_c - 1);
  EXPECT_LT(cabinets_c, laboratory.air_as_measured().value);
}

}  // namespace
}  // namespace gyrotherm::simulator
