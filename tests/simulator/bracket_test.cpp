// SPDX-License-Identifier: Apache-2.0
#include "simulator/bracket.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "simulator/virtual_laboratory.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/simulator/small_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

constexpr BracketParameters kFirst{.units = {}, .share = 0.3, .time_constant_s = 600};

/// Units a, b, … of one axis each, with thermometers that are exact, in air that stays at 20 °C. Their powers differ
/// widely.
LaboratoryParameters world_of(const std::vector<std::string>& units, std::vector<BracketParameters> brackets) {
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

TEST(Bracket, FollowsTheCabinetsWithItsTimeConstant) {
  Bracket bracket(kFirst, {20});
  for (int t = 0; t < 600; ++t) bracket.follow({30});
  EXPECT_NEAR(bracket.temperature().value, 30 - 10 * std::exp(-1), 1e-9);
  EXPECT_NEAR(bracket.seen_by_a_body({10}).value, 10 + 0.3 * (bracket.temperature().value - 10), 1e-12);
}

/// Of a cabinet that is 2 K above what it takes for the air, and 1 % more per 10 K.
TEST(Bracket, RestsWhereItsCabinetsDo) {
  const auto cabinets = [](Celsius seen) { return Celsius{seen.value + 2 + 0.002 * (seen.value - 20)}; };
  for (const double share : {0.0, 0.3, kMostBracketShare}) {
    const auto rests = bracket_at_rest(share, {-40}, cabinets);
    EXPECT_NEAR(rests.value, cabinets({-40 + share * (rests.value + 40)}).value, 1e-8) << share;
  }
}

TEST(Bracket, StaysAtRestWithItsBodies) {
  auto world = world_of({"a", "b", "c"}, {with(kFirst, {0, 1, 2})});
  VirtualLaboratory laboratory(world, {.gyro = 1});
  const auto before = thermometers(laboratory);
  const double rests_c = laboratory.bracket(0)->value;
  for (int t = 0; t < 3 * 3600; ++t) laboratory.step();
  EXPECT_NEAR(laboratory.bracket(0)->value, rests_c, 1e-6);
  for (const auto& [name, celsius] : thermometers(laboratory)) EXPECT_NEAR(celsius, before.at(name), 1e-6) << name;
}

/// A cold one is as warm as the air, and so is its bracket.
TEST(Bracket, OfColdBodiesIsAsWarmAsTheAir) {
  auto world = world_of({"a", "b"}, {with(kFirst, {0, 1})});
  std::get<ReducedGyroParameters>(world.body).cold = true;
  const VirtualLaboratory laboratory(world, {.gyro = 1});
  EXPECT_NEAR(laboratory.bracket(1)->value, 20, 1e-6);
  for (const auto& [name, celsius] : thermometers(laboratory)) EXPECT_NEAR(celsius, 20, 1e-6) << name;
}

/// Each on a bracket of its own, then both on one: the warmer one gives to the other what it has more.
TEST(Bracket, ItsBodiesHeatEachOther) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const VirtualLaboratory apart(world_of({"a", "b"}, {with(kFirst, {0}), with(kFirst, {1})}), {.gyro = seed});
    const VirtualLaboratory together(world_of({"a", "b"}, {with(kFirst, {0, 1})}), {.gyro = seed});
    const VirtualLaboratory alone(world_of({"a", "b"}, {}), {.gyro = seed});
    EXPECT_FALSE(alone.bracket(0));
    auto own = thermometers(apart), shared = thermometers(together), bare = thermometers(alone);
    const std::string warm = own["a.shell"] > own["b.shell"] ? "a" : "b";
    const std::string other = warm == "a" ? "b" : "a";
    ASSERT_GT(own[warm + ".shell"], own[other + ".shell"] + 0.01) << "their powers differ";
    for (const auto* place : {".A", ".shell"}) {
      const double lost_k = own[warm + place] - shared[warm + place];
      const double gained_k = shared[other + place] - own[other + place];
      EXPECT_GT(lost_k, 0) << place;
      EXPECT_NEAR(gained_k, lost_k, 0.1 * lost_k) << place << ", but for their films";
      EXPECT_GT(shared[other + place], bare[other + place]) << "it is warmer than in the open";
    }
    EXPECT_GT(together.bracket(0)->value, shared[other + ".shell"]);
    EXPECT_LT(together.bracket(0)->value, shared[warm + ".shell"]);
  }
}

TEST(Bracket, IsTheSameWhicheverUnitIsNamedFirst) {
  VirtualLaboratory ab(world_of({"a", "b"}, {with(kFirst, {0, 1})}), {.gyro = 2});
  VirtualLaboratory ba(world_of({"b", "a"}, {with(kFirst, {1, 0})}), {.gyro = 2});
  for (auto* laboratory : {&ab, &ba}) {
    laboratory->change_set_point({-20});
    laboratory->switch_on(true);
    for (int t = 0; t < 1800; ++t) laboratory->step();
  }
  EXPECT_EQ(thermometers(ab), thermometers(ba));
}

/// The bracket comes after the cabinets, these after the air.
TEST(Bracket, IsLateBehindItsBodies) {
  VirtualLaboratory laboratory(world_of({"a", "b"}, {with(kFirst, {0, 1})}), {.gyro = 1});
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
