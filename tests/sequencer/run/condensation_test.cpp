// SPDX-License-Identifier: Apache-2.0
/// Condensation: the interlocks `condensation` and `cold_at_door`, and a run in a chamber that measures its humidity.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/humidity.hpp"
#include "sequencer/run/run_controller.hpp"
#include "tests/sequencer/run/interlock_bench.hpp"
#include "tests/support/dry_run.hpp"

namespace gyrotherm::run {
namespace {

using interlocks::InterlockId;
using interlocks::Reaction;

TEST(Condensation, WarnsWhenDewPointReachesColdestThermometer) {
  InterlockBench bench;
  bench.chamber().dew_point = Celsius{20.9};
  bench.seconds(300);
  EXPECT_EQ(bench.alarms, 0) << "1.1 K below the thermometers";
  bench.thermometer(3, 21.8);
  EXPECT_EQ(bench.seconds(29).reaction, Reaction::go_on);
  EXPECT_EQ(bench.seconds(2).reaction, Reaction::warn);
  EXPECT_TRUE(bench.has(InterlockId::condensation));
  for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, 22.3);
  bench.seconds(60);
  EXPECT_TRUE(bench.has(InterlockId::condensation)) << "within the hysteresis";
  for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, 22.5);
  bench.seconds(11);
  EXPECT_FALSE(bench.has(InterlockId::condensation));
  EXPECT_EQ(bench.alarms, 1);
}

TEST(Condensation, ComparesWithFrostPointBelowZero) {
  InterlockBench bench;
  for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, -17.2);
  bench.chamber() = {{-18}, {-18}};
  bench.around.sent = Celsius{-18};
  bench.chamber().dew_point = Celsius{-20};
  bench.seconds(60);
  EXPECT_TRUE(bench.has(InterlockId::condensation)) << "the frost point is -18.0 °C";
}

TEST(Condensation, IgnoresUnknownHumidityAndAirThermometers) {
  InterlockBench bench;
  bench.limits.air_thermometers = {3};
  bench.thermometer(3, -10);
  bench.seconds(120);
  EXPECT_FALSE(bench.has(InterlockId::condensation));
  bench.chamber().dew_point = Celsius{15};
  bench.seconds(120);
  EXPECT_FALSE(bench.has(InterlockId::condensation)) << "thermometer 3 measures the air";
  bench.thermometer(0, 14);
  bench.seconds(31);
  ASSERT_TRUE(bench.has(InterlockId::condensation));
  bench.chamber().dew_point = std::nullopt;
  bench.seconds(3);
  EXPECT_TRUE(bench.has(InterlockId::condensation)) << "a lost reading does not end the cause";
}

TEST(ColdAtDoor, WarnsWhileDoorMayBeOpened) {
  InterlockBench bench;
  for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, 10);
  bench.around.door_may_open = true;
  bench.seconds(10);
  EXPECT_FALSE(bench.has(InterlockId::cold_at_door)) << "a virtual rig has no room";
  bench.limits.room = profile::RoomAir{};
  bench.around.door_may_open = false;
  bench.seconds(10);
  EXPECT_FALSE(bench.has(InterlockId::cold_at_door));
  bench.around.door_may_open = true;
  EXPECT_EQ(bench.second().reaction, Reaction::warn);
  EXPECT_NE(active_faults(bench.memory).front().find("open the door only at 16.8 °C"), std::string::npos);
  for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, 17);
  bench.seconds(30);
  EXPECT_TRUE(bench.has(InterlockId::cold_at_door)) << "within the hysteresis";
  for (std::size_t i = 0; i < bench.sample.thermometers.size(); ++i) bench.thermometer(i, 17.4);
  bench.seconds(11);
  EXPECT_FALSE(bench.has(InterlockId::cold_at_door));
}

TEST(ColdAtDoor, WarnsIfDoorIsOpen) {
  InterlockBench bench;
  bench.limits.room = profile::RoomAir{.dew_point = {21}};
  bench.chamber().activity = ChamberActivity::door_open;
  bench.second();
  EXPECT_TRUE(bench.has(InterlockId::cold_at_door));
}

/// Returns the virtual rig with a humidity sensor, in a room with this table.
rig::RigFile climate_rig(const std::string& room) {
  const std::string path = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml";
  auto text = read_text_file(path).value();
  const std::string map = "chambers/virtual.toml\"";
  text.replace(text.find(map), map.size(), "chambers/virtual_climate.toml\"\nhumidity = true");
  auto rig = rig::parse_rig(text + "\n[room]\n" + room + "\n", path);
  EXPECT_TRUE(rig) << gyrotherm::text(rig.error());
  return rig.value();
}

constexpr const char* kColdEnd = R"(schema = "gyrotherm-profile/1"
name = "cold end"
[[segment]]
kind = "hold"
at = 20
time = "10 min"
[[segment]]
kind = "ramp"
to = -20
rate = 2
[[segment]]
kind = "hold"
time = "2 h"
)";

class ClimateRun {
 public:
  explicit ClimateRun(const std::string& room) : file_(climate_rig(room)) {
    profile_ = profile::parse_profile(kColdEnd, "cold end").value();
    EXPECT_TRUE(add_warm_ups(profile_, file_));
    auto assembled = rig::Rig::assemble(file_, {.seed = {}, .elapsed = {}, .replay = {}});
    EXPECT_TRUE(assembled) << text(assembled.error());
    rig_ = std::move(*assembled);
    EXPECT_TRUE(rig_->prepare(Celsius{20}));
    store_ = record::Store::create(record::kInMemory, run_info("", profile_, file_, 0, {}, 0)).value();
    harness_.emplace(profile_, *rig_, *store_);
  }
  tests::RunHarness& harness() { return *harness_; }
  record::Record record() { return store_->read_back().value(); }

 private:
  rig::RigFile file_;
  profile::Profile profile_;
  std::unique_ptr<rig::Rig> rig_;
  std::unique_ptr<record::Store> store_;
  std::optional<tests::RunHarness> harness_;
};

TEST(ClimateRun, RecordsHumidityAndWarmsUpAtEnd) {
  ClimateRun run("dew_point = \"14 °C\"");
  EXPECT_EQ(run.harness().seconds(100'000), RunOutcome::complete);
  EXPECT_EQ(run.harness().run_controller().describe_cold_unit(), "");
  const auto record = run.record();
  ASSERT_EQ(record.info.segments.size(), 5u);
  ASSERT_EQ(record.chamber_humidity_percent.size(), record.slot.size());
  ASSERT_EQ(record.chamber_dew_point_c.size(), record.slot.size());
  const auto last = record.slot.size() - 1;
  for (const auto& thermometer : record.thermometers_c) EXPECT_GE(thermometer[last], 15.9);
  for (const std::size_t row : {std::size_t{60}, last / 2, last}) {
    const auto dew = dew_point({record.chamber_air_c[row]}, record.chamber_humidity_percent[row]);
    ASSERT_TRUE(dew);
    EXPECT_NEAR(record.chamber_dew_point_c[row], dew->value, 1e-3);
  }
  EXPECT_LT(record.chamber_dew_point_c[last / 2], -19) << "the water is frost on the cold walls";
  ASSERT_TRUE(record.info.warm_up);
  auto again = profile::parse_profile(record.info.profile_text, "").value();
  EXPECT_TRUE(add_recorded_warm_ups(again, record.info));
  ASSERT_EQ(again.segments.size(), record.info.segments.size());
  for (std::size_t i = 0; i < again.segments.size(); ++i)
    EXPECT_EQ(again.segments[i].name, record.info.segments[i].name) << "a resume runs the same profile";
}

TEST(ClimateRun, WarnsOperatorWhoPausesWhileUnitIsCold) {
  ClimateRun run("temperature = \"23 °C\"\nhumidity_percent = 60");
  auto& harness = run.harness();
  harness.seconds(8000);
  const auto answer = harness.run_controller().carry_out({.command = control::OperatorCommand::pause}, "Ada");
  EXPECT_TRUE(answer.done);
  EXPECT_NE(answer.text.find("open the door only at 16.8 °C or more"), std::string::npos) << answer.text;
  harness.seconds(5);
  const auto is_warned = [&] {
    return std::ranges::any_of(harness.run_controller().overview().faults_now,
                               [](const auto& line) { return line.find("too cold") != line.npos; });
  };
  EXPECT_TRUE(is_warned());
  harness.run_controller().submit(control::OperatorCommand::resume, "Ada");
  harness.seconds(20);
  EXPECT_FALSE(is_warned()) << "the door is closed";
}

TEST(ClimateRun, LeavesRecordsOfOtherRigsUnchanged) {
  const tests::DryRun dry(GYROTHERM_SOURCE_DIR "/tests/profiles/ten-seconds.toml");
  const auto info = dry.info();
  EXPECT_FALSE(info.has_humidity || info.has_dew_point || info.warm_up);
  EXPECT_TRUE(std::ranges::none_of(record::channel_columns(info),
                                   [](const auto& column) { return is_of_chamber(column.measures); }));
}

}  // namespace
}  // namespace gyrotherm::run
