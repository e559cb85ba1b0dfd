// SPDX-License-Identifier: Apache-2.0
/// Display of an active run.
#include "apps/gyrotherm/run/display.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gyrotherm::app {
namespace {

const record::AxisInfo kGyro{.kind = record::GyroKind::pulse_count, .scale = 0.5, .earth_rate = DegreesPerHour{10}};

Reading<GyroCount> make_count(std::int64_t pulses) {
  return {GyroCount{.pulses = {pulses}, .interval = std::chrono::seconds(1)}, {}};
}

TEST(BiasMeter, SubtractsEarthRate) {
  BiasMeter meter(kGyro);
  EXPECT_FALSE(meter.last_second() || meter.mean());
  meter.add_reading(make_count(22));
  EXPECT_NEAR(meter.last_second()->value, 1.0, 1e-12) << "22 pulses of 0.5 arcsec in 1 s, less 10 °/h";
  meter.add_reading(make_count(24));
  EXPECT_NEAR(meter.last_second()->value, 2.0, 1e-12);
  EXPECT_NEAR(meter.mean()->value, 1.5, 1e-12);
}

TEST(BiasMeter, SkipsFaultsInMean) {
  BiasMeter meter(kGyro);
  meter.add_reading(make_count(22));
  meter.add_reading({failure(FaultKind::timeout, "gyro", "silent"), {}});
  EXPECT_FALSE(meter.last_second());
  EXPECT_NEAR(meter.mean()->value, 1.0, 1e-12);
}

TEST(BiasMeter, AveragesLastHundredSeconds) {
  BiasMeter meter(kGyro);
  meter.add_reading(make_count(1'000'000));
  for (int i = 0; i < 100; ++i) meter.add_reading(make_count(22));
  EXPECT_NEAR(meter.mean()->value, 1.0, 1e-12);
}

struct Shown {
  Console console;
  profile::Profile profile;
  rig::RigFile rig;
  Sample sample;
  RunOverview overview;
  Shown() {
    profile.name = "random";
    profile.segments.resize(1);
    profile.segments[0].name = "cold";
    rig.simulated = true;
    rig.units = {rig::UnitSettings{}};
    rig.units[0].info.axes = {kGyro};
    rig::ThermometerSettings entry;
    entry.calibrated.resize(2);
    entry.calibrated[0].name = "A";
    entry.calibrated[1].name = "B";
    rig.thermometers = {entry};
    sample.slot = 899;
    sample.chamber = {ChamberState{.air = {-39.5}, .set_point = {-40}}, {}};
    sample.thermometers = {{Celsius{-38.25}, {}}, {failure(FaultKind::timeout, "B", "silent"), {}}};
    sample.progress.set_point = {-40};
    overview.time_left = std::chrono::seconds(2700);
  }
  [[nodiscard]] std::string text() {
    Display display(console, profile, rig, rig.simulated);
    display.add_sample(sample);
    std::string all;
    for (const auto& line : display.lines(sample, overview)) all += line + "\n";
    return all;
  }
};

TEST(Display, ShowsHowToResumeHeldRun) {
  Shown shown;
  EXPECT_EQ(shown.text().find("resume"), std::string::npos);
  shown.overview.state = RunState::held;
  shown.overview.cause = "the profile asks: switch the unit on";
  EXPECT_NE(
      shown.text().find("held: the profile asks: switch the unit on\n  to continue: \"gyrotherm tell RUN.db resume\""),
      std::string::npos)
      << shown.text();
}

TEST(Display, ShowsProgressAndMarksSimulatedRun) {
  Shown shown;
  const auto text = shown.text();
  EXPECT_TRUE(text.starts_with("SIMULATED random: 25 %, time left unknown, execute\n")) << text;
  EXPECT_NE(text.find("  45 min 00 s of simulated time left\n"), std::string::npos) << text;
  EXPECT_NE(text.find("segment 1 of 1, cold: ramping"), std::string::npos) << text;
  EXPECT_NE(text.find("set point -40.00 °C (chamber -40.00 °C), air -39.50 °C"), std::string::npos) << text;
  EXPECT_NE(text.find("A -38.25 B – °C"), std::string::npos) << text;
  shown.rig.simulated = false;
  EXPECT_TRUE(shown.text().starts_with("random: 25 %, 45 min 00 s left, ")) << "a real rig is not simulated";
  EXPECT_NE(shown.text().find("Z, ends "), std::string::npos) << "the hour of the end: " << shown.text();
  shown.overview.state = RunState::complete;
  shown.overview.time_left = Duration{};
  shown.rig.simulated = true;
  EXPECT_TRUE(shown.text().starts_with("SIMULATED random: 100 %, complete\n")) << shown.text();
}

TEST(Display, ShowsNewestUnacknowledgedAlarms) {
  Shown shown;
  Display display(shown.console, shown.profile, shown.rig, shown.rig.simulated);
  std::vector<record::Alarm> alarms;
  for (int i = 9; i >= 1; --i)
    alarms.push_back({.number = i, .interlock = "door", .text = "door (suspend): open", .count = i, .active = i > 8});
  alarms[1].acknowledged = true;
  alarms[2].suppressed_by = "host_late";
  std::string text;
  for (const auto& line : display.lines(shown.sample, shown.overview, alarms)) text += line + "\n";
  EXPECT_NE(text.find("  ALARM 9 (active, 9 times): door (suspend): open\n"
                      "  ALARM 6 (returned, 6 times): door (suspend): open\n"
                      "  ALARM 5 (returned, 5 times): door (suspend): open\n"
                      "  7 unacknowledged alarms\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("shelved"), std::string::npos) << text;
}

TEST(Display, CountsShelvedAlarmsWithoutShowingThem) {
  Shown shown;
  Display display(shown.console, shown.profile, shown.rig, shown.rig.simulated);
  const record::Alarm alarm{
      .number = 7, .interlock = "stuck", .text = "stuck (warn): A", .acknowledged = true, .shelved_by = "ada"};
  for (const int count : {1, 2}) {
    const std::vector<record::Alarm> alarms(static_cast<std::size_t>(count), alarm);
    const auto lines = display.lines(shown.sample, shown.overview, alarms);
    EXPECT_EQ(std::ranges::count(lines, count == 1 ? "  1 shelved alarm" : "  2 shelved alarms"), 1);
    EXPECT_EQ(std::ranges::count_if(lines, [](const auto& line) { return line.find("ALARM") != line.npos; }), 0);
  }
}

TEST(Display, FitsIntoSixtyColumns) {
  Shown shown;
  shown.rig.thermometers[0].calibrated.resize(9);
  shown.sample.thermometers.resize(9, {Celsius{-38.25}, {}});
  for (std::size_t i = 0; i < 9; ++i) shown.rig.thermometers[0].calibrated[i].name = "shell-" + std::to_string(i);
  Display display(shown.console, shown.profile, shown.rig, shown.rig.simulated);
  std::size_t found = 0;
  for (const auto& line : display.lines(shown.sample, shown.overview)) {
    if (line.find("shell-") == std::string::npos) continue;
    EXPECT_LE(line.size(), 62u) << line;
    ++found;
  }
  EXPECT_EQ(found, 3u) << "none is cut off";
}

TEST(Display, ShowsBiasAndFaultsBeforeTemperatures) {
  Shown shown;
  shown.overview.faults_now = {"gyro silent for 5 s"};
  const auto text = shown.text();
  const auto air = text.find("air -39.50"), fault = text.find("fault: gyro silent"), bias = text.find("bias "),
             temperature = text.find(" A -38.25");
  ASSERT_NE(temperature, std::string::npos) << text;
  EXPECT_LT(air, fault) << text;
  EXPECT_LT(fault, bias) << text;
  EXPECT_LT(bias, temperature) << text;
}

TEST(Display, ShowsStateCauseAndActiveFaults) {
  Shown shown;
  shown.overview.state = RunState::suspended;
  shown.overview.cause = "the chamber is silent";
  shown.overview.behind_plan = std::chrono::seconds(65);
  shown.overview.faults_now = {"chamber: no reply", "thermometer B: silent"};
  shown.sample.chamber = {failure(FaultKind::timeout, "chamber", "no reply in 500 ms"), {}};
  const auto text = shown.text();
  EXPECT_NE(text.find("suspended: the chamber is silent (1 min 05 s behind plan)"), std::string::npos) << text;
  EXPECT_NE(text.find("chamber: no reply in 500 ms"), std::string::npos) << text;
  EXPECT_NE(text.find("fault: chamber: no reply\n  fault: thermometer B: silent\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace gyrotherm::app
