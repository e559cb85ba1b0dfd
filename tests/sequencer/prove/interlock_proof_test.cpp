// SPDX-License-Identifier: Apache-2.0
/// The proof test of the interlocks, with the settings of the shipped rigs and with broken ones.
#include "sequencer/prove/interlock_proof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <tuple>
#include <utility>

#include "core/file.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::prove {
namespace {

rig::RigFile shipped_rig(const std::string& name) {
  return rig::read_rig(GYROTHERM_SOURCE_DIR "/profiles/rigs/" + name + ".toml").value();
}

InterlockOutcome outcome_of(const std::vector<InterlockOutcome>& all, interlocks::InterlockId id) {
  return *std::ranges::find(all, id, &InterlockOutcome::id);
}

TEST(InterlockProof, CoversEveryInterlockOnce) {
  std::set<interlocks::InterlockId> seen;
  for (const auto& outcome : inject_all(shipped_rig("virtual"))) EXPECT_TRUE(seen.insert(outcome.id).second);
  EXPECT_EQ(seen.size(), interlocks::kInterlocks);
}

TEST(InterlockProof, PassesForShippedRigs) {
  for (const auto* name :
       {"virtual", "virtual-supply", "virtual-lot", "example-f4t-lakeshore-kvh", "example-binder-dcon-stim300"}) {
    int tested = 0;
    for (const auto& outcome : inject_all(shipped_rig(name))) {
      EXPECT_EQ(outcome.cause, "") << name << " " << interlocks::name(outcome.id);
      if (outcome.omitted.empty()) ++tested;
      EXPECT_EQ(outcome.seconds > 0, outcome.omitted.empty()) << name << " " << interlocks::name(outcome.id);
    }
    EXPECT_GE(tested, 33) << name;
  }
}

TEST(InterlockProof, ReportsReactionOfPolicy) {
  auto rig = shipped_rig("virtual");
  rig.limits.policy[static_cast<std::size_t>(interlocks::InterlockId::door)] = interlocks::Reaction::hold;
  EXPECT_EQ(outcome_of(inject_all(rig), interlocks::InterlockId::door).reaction, interlocks::Reaction::hold);
}

TEST(InterlockProof, FindsLimitThatCannotAct) {
  auto rig = shipped_rig("virtual");
  rig.limits.follow_band = {1000};  // more than the chamber's range
  const auto all = inject_all(rig);
  EXPECT_EQ(outcome_of(all, interlocks::InterlockId::following).cause, "does not act on injected values");
  EXPECT_EQ(outcome_of(all, interlocks::InterlockId::door).cause, "");
}

TEST(InterlockProof, OmitsLimitThatActsAfterLongestTest) {
  using interlocks::InterlockId;
  auto rig = shipped_rig("virtual");
  auto& limits = rig.limits;
  const std::tuple<InterlockId, Duration*> cases[] = {
      {InterlockId::no_thermal_response, &limits.response_time},
      {InterlockId::gyro_dead, &limits.gyro_dead_after},
      {InterlockId::frozen, &limits.frozen_after},
      {InterlockId::following, &limits.follow_time},
      {InterlockId::following, &limits.chamber_lag},
      {InterlockId::chamber_silent, &limits.suspend_after},
  };
  for (const auto& [id, limit] : cases) {
    const auto usual = std::exchange(*limit, std::chrono::hours(20));
    const auto outcome = outcome_of(inject_all(rig), id);
    EXPECT_EQ(outcome.cause, "") << interlocks::name(id);
    EXPECT_EQ(outcome.omitted.find("it acts only after "), 0u) << interlocks::name(id) << outcome.omitted;
    *limit = usual;
  }
}

/// Each of these limits is permitted, and its interlock acts.
TEST(InterlockProof, PassesForUnusualLimits) {
  const std::pair<const char*, std::function<void(interlocks::InterlockLimits&)>> cases[] = {
      {"a small disagreement of the chamber", [](auto& limits) { limits.chamber_disagreement = {0.9}; }},
      {"with thermometers in the air",
       [](auto& limits) {
         limits.chamber_disagreement = {0.3};
         limits.air_thermometers = {0};
       }},
      {"fast air", [](auto& limits) { limits.air_fastest = {250}; }},
      {"fast thermometers", [](auto& limits) { limits.thermometers_fastest = {300}; }},
      {"a wide band of following", [](auto& limits) { limits.follow_band = {45}; }},
      {"a slow chamber", [](auto& limits) { limits.chamber_lag = std::chrono::minutes(40); }},
      {"a small drift", [](auto& limits) { limits.drift = {0.2}; }},
      {"a small disagreement", [](auto& limits) { limits.disagreement = {0.4}; }},
      {"late interlocks",
       [](auto& limits) {
         limits.gyro_dead_after = limits.frozen_after = limits.response_time = std::chrono::hours(3);
       }},
      {"a large margin of condensation", [](auto& limits) { limits.condensation_margin = {30}; }},
  };
  for (const auto* name : {"virtual", "example-f4t-lakeshore-kvh"})
    for (const auto& [what, change] : cases) {
      auto rig = shipped_rig(name);
      change(rig.limits);
      for (const auto& outcome : inject_all(rig))
        EXPECT_EQ(outcome.cause, "") << name << ", " << what << ": " << interlocks::name(outcome.id);
    }
}

TEST(InterlockProof, FindsLimitThatActsWithoutFault) {
  auto rig = shipped_rig("virtual");
  rig.limits.air_fastest = {0.01};
  EXPECT_EQ(outcome_of(inject_all(rig), interlocks::InterlockId::air_rate).cause, "acts on readings without a fault");
}

}  // namespace
}  // namespace gyrotherm::prove
