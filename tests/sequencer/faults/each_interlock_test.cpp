// SPDX-License-Identifier: Apache-2.0
/// Tests docs/interlocks.md. For each interlock, one thing breaks in a virtual instrument, on a line, on the disk or
/// in the clock. Only that interlock acts, and the documented reaction follows.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/sequencer/faults/broken_things.hpp"

namespace gyrotherm::faults {
namespace {

constexpr Celsius kSafe{20};

class EachInterlock : public ::testing::TestWithParam<BrokenThing> {
 protected:
  static constexpr int kWhile = 30;  ///< seconds for which a fault lasts

  void repair() {
    if (broken_.repairs) broken_.repairs(d_);
  }
  [[nodiscard]] bool is_active() const { return !d_.active_alarms().empty(); }
  [[nodiscard]] bool are_all_active() const { return d_.active_alarms().size() > broken_.also.size(); }

  void expect_warning_only();
  void expect_wait_and_automatic_resume();
  void expect_wait_for_operator();
  void expect_chamber_made_safe();

  const BrokenThing& broken_ = GetParam();
  BreakableRun d_{GetParam().setting};
};

/// The profile continues during the warning.
void EachInterlock::expect_warning_only() {
  const auto before = d_.progress();
  d_.seconds(kWhile);
  repair();
  const auto over = broken_.is_permanent ? 0 : d_.until([&] { return !is_active(); }, broken_.clears_within);
  EXPECT_NE(over, -1) << "the alarm does not clear by itself";
  EXPECT_EQ(d_.run_controller().run_state(), RunState::execute);
  EXPECT_EQ(d_.progress().in_segment - before.in_segment, std::chrono::seconds(kWhile + over));
}

/// The profile's clock and the set point stop. The run does not overwrite a foreign change.
void EachInterlock::expect_wait_and_automatic_resume() {
  const auto stood = d_.progress();
  const auto set_point = d_.chamber_set_point();
  EXPECT_EQ(d_.run_controller().run_state(), RunState::suspended);
  for (int i = 0; i < kWhile && !broken_.returns_to_set_point; ++i) {
    d_.seconds(1);
    ASSERT_EQ(d_.chamber_set_point(), set_point);
    ASSERT_EQ(d_.progress(), stood);
  }
  repair();
  const auto on = d_.until(RunState::execute, broken_.clears_within);
  EXPECT_GE(on, broken_.repairs ? d_.file().run_limits.resume_delay / std::chrono::seconds(1) : 0);
  EXPECT_EQ(d_.progress().segment, stood.segment);
  EXPECT_LE(d_.progress().in_segment - stood.in_segment, std::chrono::seconds(1));
  EXPECT_NE(d_.until([&] { return !is_active(); }, broken_.clears_within), -1) << "it is over";
  EXPECT_NEAR(d_.chamber_set_point().value, d_.progress().set_point.value, 0.1);
}

void EachInterlock::expect_wait_for_operator() {
  const auto stood = d_.progress();
  const auto set_point = d_.chamber_set_point();
  EXPECT_EQ(d_.run_controller().run_state(), RunState::held);
  repair();
  d_.seconds(900);
  EXPECT_FALSE(is_active()) << "its alarm has cleared";
  EXPECT_EQ(d_.run_controller().run_state(), RunState::held) << "it does not resume by itself";
  EXPECT_EQ(d_.progress(), stood);
  EXPECT_EQ(d_.chamber_set_point(), set_point);
  d_.run_controller().submit(control::OperatorCommand::resume, "Ada");
  EXPECT_NE(d_.until(RunState::execute, 1), -1);
}

/// The chamber is made safe in the same second. The run ends when the chamber has confirmed its safe state, and does
/// not start again.
void EachInterlock::expect_chamber_made_safe() {
  EXPECT_EQ(d_.run_controller().run_state(), RunState::aborting);
  EXPECT_EQ(d_.chamber_set_point(), kSafe);
  EXPECT_EQ(d_.seconds(10), run::RunOutcome::made_safe);
  EXPECT_EQ(d_.run_controller().run_state(), RunState::aborted);
  EXPECT_TRUE(d_.run_controller().is_safe());
  EXPECT_EQ(d_.chamber_set_point(), kSafe);
}

TEST_P(EachInterlock, ActsAloneAsDocumentedWhenOneThingBreaks) {
  d_.seconds(broken_.at);
  ASSERT_EQ(d_.run_controller().run_state(), RunState::execute);
  ASSERT_TRUE(d_.active_alarms().empty()) << d_.active_alarms().front();
  broken_.breaks(d_);
  ASSERT_NE(d_.until([&] { return are_all_active(); }, broken_.acts_within), -1) << "the interlock does not act";
  EXPECT_EQ(d_.active_alarms().size(), 1 + broken_.also.size());
  switch (broken_.reaction) {
    case interlocks::Reaction::warn: expect_warning_only(); break;
    case interlocks::Reaction::suspend: expect_wait_and_automatic_resume(); break;
    case interlocks::Reaction::hold: expect_wait_for_operator(); break;
    case interlocks::Reaction::abort: expect_chamber_made_safe(); break;
    case interlocks::Reaction::go_on: FAIL();
  }
  auto alarms = BreakableRun::alarms_in(d_.record());
  for (const auto cause : broken_.also)
    EXPECT_EQ(std::erase_if(alarms, [&](const auto& alarm) { return alarm.cause == name(cause); }), 1u) << name(cause);
  ASSERT_EQ(alarms.size(), 1u) << "one alarm, and none with another cause";
  EXPECT_EQ(alarms.front().cause, name(broken_.cause));
  EXPECT_EQ(alarms.front().reaction, name(broken_.reaction));
}

INSTANTIATE_TEST_SUITE_P(Interlocks, EachInterlock, ::testing::ValuesIn(broken_things()),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(Interlocks, AreAllTestedByBreakingOneThing) {
  std::set<interlocks::InterlockId> shown;
  for (const auto& thing : broken_things()) {
    shown.insert(thing.cause);
    const bool near_a_limit =
        thing.cause == interlocks::InterlockId::following && thing.reaction == interlocks::Reaction::abort;
    EXPECT_EQ(thing.reaction, near_a_limit ? interlocks::Reaction::abort : interlock(thing.cause).usual) << thing.name;
  }
  for (std::size_t i = 0; i < interlocks::kInterlocks; ++i)
    EXPECT_TRUE(shown.contains(static_cast<interlocks::InterlockId>(i)))
        << name(static_cast<interlocks::InterlockId>(i));
}

/// Returns the first fault that shows the cause.
const BrokenThing& find_broken_thing(interlocks::InterlockId cause) {
  return *std::ranges::find(broken_things(), cause, &BrokenThing::cause);
}

TEST(Interlocks, AbortRunWhenSilenceDoesNotEnd) {
  for (const auto cause : {interlocks::InterlockId::chamber_silent, interlocks::InterlockId::thermometers_lost,
                           interlocks::InterlockId::gyro_silent}) {
    const auto& broken = find_broken_thing(cause);
    auto setting = broken.setting;
    setting.rig = [&](rig::RigFile& file) {
      if (broken.setting.rig) broken.setting.rig(file);
      file.limits.chamber_lost = file.limits.thermometers_lost = file.limits.gyro_lost = std::chrono::seconds(90);
    };
    BreakableRun d(setting);
    d.seconds(broken.at);
    broken.breaks(d);
    EXPECT_NEAR(d.until(RunState::aborting, 200), 90, 2) << broken.name;
    if (cause == interlocks::InterlockId::chamber_silent) {
      EXPECT_EQ(d.seconds(60), run::RunOutcome::going_on) << "the chamber's state is unknown";
      broken.repairs(d);
    }
    EXPECT_EQ(d.seconds(15), run::RunOutcome::made_safe) << broken.name;
    EXPECT_EQ(d.chamber_set_point(), kSafe);
    const auto alarms = BreakableRun::alarms_in(d.record());
    EXPECT_EQ(alarms.size(), 2 + broken.also.size()) << "raised, and raised again as an abort";
    EXPECT_EQ(std::ranges::count(alarms, name(interlocks::Reaction::abort), &AlarmRecorded::reaction), 1);
  }
}

TEST(Interlocks, AcceptChamberThatRoundsToWholeKelvins) {
  BreakableRun d({.rig = [](rig::RigFile& file) {
    auto& items = file.chamber_map.items;
    auto& set_point = *std::ranges::find(items, "set_point", &drivers::RegisterItem::name);
    set_point.type = drivers::RegisterType::s16;
    set_point.resolution = 1;
    file.safe_set_point = {20.4};
  }});
  d.seconds(500);
  EXPECT_EQ(d.run_controller().run_state(), RunState::execute);
  find_broken_thing(interlocks::InterlockId::chamber_alarm).breaks(d);
  EXPECT_EQ(d.seconds(10), run::RunOutcome::made_safe);
  EXPECT_EQ(d.chamber_set_point(), Celsius{20});
  EXPECT_EQ(BreakableRun::alarms_in(d.record()).size(), 1u);
}

/// Another client writes 65 °C in every other second.
TEST(Interlocks, SuspendWithinSecondsWhenSetPointAlternates) {
  BreakableRun d({});
  d.seconds(900);
  int seconds = 0;
  for (; seconds < 60 && d.run_controller().run_state() == RunState::execute; ++seconds) {
    d.plant().laboratory().change_set_point({seconds % 2 == 0 ? 65.0 : 40.0});
    d.seconds(1);
  }
  EXPECT_LE(seconds, 4);
  EXPECT_EQ(d.run_controller().run_state(), RunState::suspended);
}

/// Thermometers H and shell are exchanged on a ramp.
TEST(Interlocks, NameBothExchangedThermometers) {
  BreakableRun d({.rig = [](rig::RigFile& file) { file.limits.drift = {0.5}; }});
  d.seconds(560);
  d.break_plant([](simulator::LaboratoryFaults& faults) {
    std::swap(faults.thermometers[7].location, faults.thermometers[8].location);
  });
  d.seconds(60);
  const auto alarms = BreakableRun::alarms_in(d.record());
  ASSERT_EQ(alarms.size(), 2u);
  for (const auto& alarm : alarms) EXPECT_EQ(alarm.cause, "drifting");
}

/// Readings that were stored before the instrument was reported as frozen remain; later ones are stored as faults.
TEST(Interlocks, StoreNoReadingsOfFrozenInstrumentOrDeadGyro) {
  BreakableRun d({});
  d.seconds(900);
  find_broken_thing(interlocks::InterlockId::gyro_dead).breaks(d);
  d.seconds(70);
  find_broken_thing(interlocks::InterlockId::frozen).breaks(d);
  d.seconds(130);
  const auto& last = d.run_controller().last();
  for (std::size_t i = 0; i < 8; ++i) EXPECT_FALSE(last.thermometers[i].value) << i;
  EXPECT_TRUE(last.thermometers[8].value) << "another instrument";
  EXPECT_FALSE(last.units[0].count.value);
}

TEST(Interlocks, AbortRunWhenWaitDoesNotEnd) {
  for (const auto cause : {interlocks::InterlockId::door, interlocks::InterlockId::slept}) {
    const auto& broken = find_broken_thing(cause);
    BreakableRun d({.rig = [](rig::RigFile& file) {
      file.run_limits.longest_suspended = file.run_limits.longest_held = std::chrono::seconds(120);
    }});
    d.seconds(broken.at);
    broken.breaks(d);
    d.until(cause == interlocks::InterlockId::door ? RunState::suspended : RunState::held, 3);
    EXPECT_EQ(d.until(RunState::aborting, 200), 120) << broken.name;
    EXPECT_EQ(d.seconds(5), run::RunOutcome::made_safe) << broken.name;
    EXPECT_EQ(d.chamber_set_point(), kSafe);
  }
}

}  // namespace
}  // namespace gyrotherm::faults
