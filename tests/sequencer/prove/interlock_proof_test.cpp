// SPDX-License-Identifier: Apache-2.0
/// The proof test of the interlocks, with the settings of the shipped rigs and with broken ones.
#include "sequencer/prove/interlock_proof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

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
  rig.limits.response_time = std::chrono::hours(24 * 365);  // a test of it would take a year
  rig.limits.follow_band = {1000};
  const auto all = inject_all(rig);
  EXPECT_EQ(outcome_of(all, interlocks::InterlockId::following).cause, "does not act on injected values");
  EXPECT_EQ(outcome_of(all, interlocks::InterlockId::no_thermal_response).cause, "does not act on injected values");
  EXPECT_EQ(outcome_of(all, interlocks::InterlockId::door).cause, "");
}

TEST(InterlockProof, FindsLimitThatActsWithoutFault) {
  auto rig = shipped_rig("virtual");
  rig.limits.air_fastest = {0.01};
  EXPECT_EQ(outcome_of(inject_all(rig), interlocks::InterlockId::air_rate).cause, "acts on readings without a fault");
}

}  // namespace
}  // namespace gyrotherm::prove
