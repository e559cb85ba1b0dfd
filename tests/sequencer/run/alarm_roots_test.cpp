// SPDX-License-Identifier: Apache-2.0
/// Alarms that have a common cause refer to its alarm, the root.
#include "sequencer/run/alarm_roots.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::run {
namespace {

using interlocks::InterlockAlarm;
using interlocks::InterlockId;
using interlocks::Reaction;
using std::chrono_literals::operator""s;

tl::unexpected<Fault> lost() { return failure(FaultKind::timeout, "instrument", "no reply"); }

/// A chamber, two scanners of two thermometers and a gyro at the given addresses.
class Roots {
 public:
  Roots(const std::string& chamber, const std::string& scanner_1, const std::string& scanner_2,
        const std::string& gyro) {
    rig::RigFile rig;
    rig.chamber_line = chamber;
    rig.thermometers.resize(2);
    rig.thermometers[0].line = scanner_1;
    rig.thermometers[0].channels = {"A", "B"};
    rig.thermometers[1].line = scanner_2;
    rig.thermometers[1].channels = {"C", "D"};
    rig.units = {rig::UnitSettings{}};
    rig.gyro_lines.push_back({.line = gyro, .frame = {}, .stream = {}, .shares = {{.unit = 0}}});
    lines_ = rig_lines(rig);
    sample.chamber.value = ChamberState{{20}, {20}};
    sample.thermometers.assign(4, {Celsius{20}, {}});
    sample.units.resize(1);
    sample.units[0].count.value = GyroCount{{1}, 1s};
  }

  RootResult second(std::vector<InterlockId> raised = {}, Duration missed = {}) {
    std::vector<InterlockAlarm> alarms;
    for (const auto id : raised) alarms.push_back({id, Reaction::warn, "silent", ""});
    return step_with(std::move(alarms), missed);
  }
  RootResult step_with(std::vector<InterlockAlarm> alarms, Duration missed = {}) {
    auto result =
        find_roots(lines_, memory_,
                   {.sample = sample, .missed = missed, .longest_missed = 120s, .clear_after = 10s, .raised = alarms});
    memory_ = result.memory;
    return result;
  }
  void silence_thermometers(std::initializer_list<std::size_t> columns) {
    for (const auto column : columns) sample.thermometers[column].value = lost();
  }
  Sample sample;

 private:
  std::vector<RigLine> lines_;
  RootMemory memory_;
};

Roots apart() { return {"tcp://10.0.0.5:502", "tcp://10.0.0.6:502", "serial:/dev/ttyUSB0", "serial:/dev/ttyUSB1"}; }

TEST(AlarmRoots, NamesLateHostAsRootOfEachSilence) {
  for (const auto id : {InterlockId::chamber_silent, InterlockId::gyro_silent, InterlockId::unit_silent,
                        InterlockId::channel_lost, InterlockId::needed_channel_lost, InterlockId::thermometers_lost}) {
    auto roots = apart();
    EXPECT_TRUE(roots.second({}, 2s).raised.empty()) << "one late second is no alarm";
    for (int i = 0; i < 20; ++i) (void)roots.second();
    const auto result = roots.second({id});
    ASSERT_EQ(result.raised.size(), 1u) << name(id);
    EXPECT_EQ(result.raised[0].id, kHostLate);
    EXPECT_EQ(result.roots, std::vector<std::string>{kHostLate});
  }
}

TEST(AlarmRoots, NamesNoRootForOtherCauses) {
  auto roots = apart();
  (void)roots.second({}, 2s);
  roots.silence_thermometers({0, 1});
  for (const auto id : {InterlockId::door, InterlockId::air_limit, InterlockId::foreign_set_point, InterlockId::stuck,
                        InterlockId::storage})
    EXPECT_EQ(roots.second({id}).roots, std::vector<std::string>{""}) << name(id);
}

TEST(AlarmRoots, EndsMinuteAfterLastLateSecond) {
  auto roots = apart();
  (void)roots.second({InterlockId::gyro_silent}, 2s);
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(roots.second().cleared.empty()) << i;
  const auto result = roots.second();
  ASSERT_EQ(result.cleared.size(), 1u);
  EXPECT_EQ(result.cleared[0].id, kHostLate);
  EXPECT_EQ(roots.second({InterlockId::gyro_silent}).roots, std::vector<std::string>{""});
}

TEST(AlarmRoots, RaisesAlarmWhenHostIsLateForTenSeconds) {
  auto roots = apart();
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(roots.second({}, 2s).raised.empty());
  EXPECT_EQ(roots.second({}, 2s).raised.size(), 1u);
  EXPECT_TRUE(roots.second({}, 2s).raised.empty()) << "once until it clears";
}

TEST(AlarmRoots, IgnoresSleepOfMachine) {
  auto roots = apart();
  const auto result = roots.second({InterlockId::slept, InterlockId::gyro_silent}, 121s);
  EXPECT_TRUE(result.raised.empty());
  EXPECT_EQ(result.roots, (std::vector<std::string>{"", ""}));
}

TEST(AlarmRoots, NamesLineOfLostScanner) {
  for (const auto id : {InterlockId::channel_lost, InterlockId::needed_channel_lost, InterlockId::thermometers_lost}) {
    auto roots = apart();
    roots.silence_thermometers({2, 3});
    const auto result = roots.second({id});
    ASSERT_EQ(result.raised.size(), 1u) << name(id);
    EXPECT_EQ(result.raised[0].id, kLineLost);
    EXPECT_EQ(result.raised[0].subject, "serial:/dev/ttyUSB0");
    EXPECT_EQ(result.roots, std::vector<std::string>{"line_lost serial:/dev/ttyUSB0"});
  }
}

TEST(AlarmRoots, NamesNoLineWhileAnotherInstrumentAnswersOnIt) {
  auto roots = apart();
  roots.silence_thermometers({2});
  EXPECT_TRUE(roots.second({InterlockId::channel_lost}).raised.empty()) << "D still answers";
  roots.silence_thermometers({0, 1});
  EXPECT_TRUE(roots.second({InterlockId::thermometers_lost}).raised.empty())
      << "not all lost channels are on that line";
}

TEST(AlarmRoots, FindsLineOfSubject) {
  for (const auto* subject : {"thermometer 2", "C", "D"}) {
    auto roots = apart();
    roots.silence_thermometers({0, 2, 3});
    const auto result = roots.step_with({{InterlockId::channel_lost, Reaction::warn, "silent", subject},
                                         {InterlockId::channel_lost, Reaction::warn, "silent", "A"},
                                         {InterlockId::channel_lost, Reaction::warn, "silent", "u1.current"}});
    EXPECT_EQ(result.roots, (std::vector<std::string>{"line_lost serial:/dev/ttyUSB0", "", ""})) << subject;
  }
}

TEST(AlarmRoots, NamesOneRootForSharedLine) {
  Roots roots("tcp://10.0.0.9:502", "tcp://10.0.0.9:502", "serial:/dev/ttyUSB0", "tcp://10.0.0.9:502");
  roots.silence_thermometers({0, 1});
  roots.sample.chamber.value = lost();
  EXPECT_EQ(roots.second({InterlockId::chamber_silent}).roots, std::vector<std::string>{""}) << "the gyro answers";
  roots.sample.units[0].count.value = lost();
  const auto result = roots.second({InterlockId::chamber_silent, InterlockId::gyro_silent, InterlockId::channel_lost});
  EXPECT_EQ(result.raised.size(), 1u);
  EXPECT_EQ(result.roots, std::vector<std::string>(3, "line_lost tcp://10.0.0.9:502"));
}

TEST(AlarmRoots, TreatsVirtualInstrumentsAsSeparate) {
  Roots roots("virtual", "virtual", "virtual", "virtual");
  roots.silence_thermometers({0, 1});
  EXPECT_EQ(roots.second({InterlockId::channel_lost}).roots, std::vector<std::string>{"line_lost thermometer 1"});
}

TEST(AlarmRoots, NamesNoRootForLineOfSingleInstrument) {
  auto roots = apart();
  roots.sample.chamber.value = lost();
  roots.sample.units[0].count.value = lost();
  EXPECT_TRUE(roots.second({InterlockId::chamber_silent, InterlockId::gyro_silent}).raised.empty());
}

TEST(AlarmRoots, LineAlarmEndsAfterItsConsequences) {
  auto roots = apart();
  roots.silence_thermometers({2, 3});
  (void)roots.second({InterlockId::channel_lost});
  roots.sample.thermometers[2].value = Celsius{20};
  for (int i = 0; i < 14; ++i) EXPECT_TRUE(roots.second().cleared.empty()) << i;
  ASSERT_EQ(roots.second().cleared.size(), 1u);
  roots.silence_thermometers({2});
  EXPECT_EQ(roots.second({InterlockId::channel_lost}).raised.size(), 1u) << "raised again";
}

}  // namespace
}  // namespace gyrotherm::run
