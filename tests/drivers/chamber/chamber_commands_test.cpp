// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "drivers/chamber/modbus_chamber.hpp"
#include "tests/support/fakes.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::seconds;

constexpr const char* kMap = R"(schema = "gyrotherm-chamber/1"
name = "oven"
vendor = "test"
source = "none"
[link]
status_every = 2
[[register]]
name = "air_temperature"
address = 1
type = "s16"
scale = 0.1
sentinels = { "sensor broken" = 32767 }
[[register]]
name = "set_point"
address = 3
type = "s16"
decimals = "decimals"
unit_register = "unit"
access = "rw"
within = "1 s"
[[register]]
name = "decimals"
address = 4
type = "u16"
[[register]]
name = "unit"
address = 5
type = "u16"
codes = { celsius = 0, fahrenheit = 1 }
[[register]]
name = "command"
address = 6
type = "u16"
access = "command"
codes = { run = 1, stop = 4 }
[[register]]
name = "state"
address = 7
type = "u16"
codes = { stopped = 0, constant = 1, program = [2, 3] }
[[register]]
name = "alarms"
address = 8
type = "u16"
flags = { door_open = 0, emergency_stop = 1, water_low = 2 }
[[register]]
name = "light"
address = 9
type = "bits"
bit = 3
access = "rw"
[[register]]
name = "highest"
address = 10
type = "s16"
scale = 0.1
[limits]
lowest = -60
highest_register = "highest"
[sequence]
start = [
  { when = { register = "state", is = "program" }, write = "command", code = "stop" },
  { pause = "2 s" },
  { write = "command", code = "run" },
  { wait = { register = "state", is = "constant" }, within = "3 s" },
]
stop = [{ write = "command", code = "stop" }, { wait = { register = "state", is = "stopped" }, within = "3 s" }]
acknowledge = [{ write = "light", value = 1 }]
[[state]]
activity = "emergency_stop"
register = "alarms"
is = "emergency_stop"
[[state]]
activity = "door_open"
register = "alarms"
is = "door_open"
[[state]]
activity = "running"
register = "state"
is = "constant"
[[state]]
activity = "off"
register = "state"
is_not = ["constant", "program"]
[[alarm]]
severity = "warning"
register = "alarms"
is = ["door_open", "water_low"]
[[alarm]]
severity = "stop"
text = "somebody pressed it"
register = "alarms"
is = "emergency_stop"
)";

/// A unit that executes writes after a delay, with a clock that only pauses advance.
class SlowUnit final : public Registers {
 public:
  std::map<std::uint16_t, std::uint16_t> words{{1, 215}, {3, 200}, {4, 1}, {5, 0},   {6, 0},
                                               {7, 0},   {8, 0},   {9, 5}, {10, 800}};
  std::vector<std::pair<std::uint16_t, std::uint16_t>> written;
  std::function<void(std::uint16_t address, std::uint16_t word)> obey = [](auto, auto) {};
  std::uint16_t refused_from = 0xFFFF;
  Fault refusal{FaultKind::refused, "unit", "exception 2, illegal data address"};
  int reads = 0;
  /// Addresses read, in order.
  std::vector<std::uint16_t> asked;
  /// Advances the clock for each exchange.
  std::function<void()> each_exchange = [] {};
  /// Returns whether this answer is lost.
  std::function<bool()> loses = [] { return false; };
  /// Returns whether this write arrives.
  std::function<bool()> arrives = [] { return true; };

  Result<std::vector<std::uint16_t>> read(ReadFunction, std::uint16_t address, std::uint16_t count) override {
    ++reads;
    asked.push_back(address);
    each_exchange();
    if (loses()) return failure(FaultKind::timeout, "unit", "no reply");
    std::vector<std::uint16_t> found;
    for (std::uint16_t i = 0; i < count; ++i) found.push_back(words[static_cast<std::uint16_t>(address + i)]);
    if (address >= refused_from) return failure(refusal);
    return found;
  }
  Result<void> write(WriteFunction, std::uint16_t address, std::span<const std::uint16_t> values) override {
    each_exchange();
    if (!arrives()) return failure(FaultKind::timeout, "unit", "no reply");
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto at = static_cast<std::uint16_t>(address + i);
      written.emplace_back(at, values[i]);
      if (at != 6) words[at] = values[i];
      obey(at, values[i]);
    }
    return {};
  }
};

class Timekeeper final : public Pauses {
 public:
  std::function<void(Duration now)> tick = [](Duration) {};
  Duration now() const override { return now_; }
  void rest(Duration time) override {
    now_ += time;
    tick(now_);
  }

 private:
  Duration now_{};
};

class ChamberCommands : public testing::Test {
 protected:
  void SetUp() override {
    auto map = parse_register_map(kMap, "map.toml");
    ASSERT_TRUE(map) << text(map.error());
    auto made = std::make_unique<SlowUnit>();
    auto keeper = std::make_unique<Timekeeper>();
    unit = made.get();
    time = keeper.get();
    chamber = make_modbus_chamber(std::move(*map), std::move(made), std::move(keeper));
  }
  using Written = std::vector<std::pair<std::uint16_t, std::uint16_t>>;
  SlowUnit* unit{};
  Timekeeper* time{};
  std::unique_ptr<Chamber> chamber;
};

TEST_F(ChamberCommands, CompletesStartByStateRegister) {
  Duration commanded{};
  unit->obey = [&](auto address, auto word) {
    if (address == 6 && word == 1) commanded = time->now();
  };
  time->tick = [&](Duration now) {
    if (commanded > Duration{} && now - commanded >= seconds(1)) unit->words[7] = 1;
  };
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(unit->written, (Written{{6, 1}}));
  EXPECT_EQ(commanded, seconds(2)) << "after the pause";
  EXPECT_GE(time->now(), seconds(3));
}

TEST_F(ChamberCommands, TimesOutIfStartIsNotShown) {
  const auto done = chamber->start();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, FaultKind::timeout);
  EXPECT_EQ(text(done.error()), "chamber register 7 (state): is stopped, expected constant within 3 s");
}

TEST_F(ChamberCommands, SkipsStepIfConditionIsNotSatisfied) {
  unit->words[7] = 3;
  unit->obey = [&](auto address, auto word) {
    if (address == 6) unit->words[7] = word == 1 ? 1 : 0;
  };
  ASSERT_TRUE(chamber->start());
  EXPECT_EQ(unit->written, (Written{{6, 4}, {6, 1}})) << "a program ran, and was stopped first";
}

/// Returns the map with these commands.
RegisterMap map_with(const std::string& start, const std::string& stop) {
  std::string text_of = kMap;
  const auto from = text_of.find("start = ["), to = text_of.find("acknowledge = [");
  text_of.replace(from, to - from, "start = [" + start + "]\nstop = [" + stop + "]\n");
  return parse_register_map(text_of, "map.toml").value();
}

TEST(ChamberSequences, StopTriesEveryStepAndReportsFirstFailure) {
  const std::string steps = "{ write = \"command\", code = \"stop\" }, { write = \"light\", value = 1 }";
  auto made = std::make_unique<SlowUnit>();
  auto* unit = made.get();
  const auto chamber = make_modbus_chamber(map_with(steps, steps), std::move(made), std::make_unique<Timekeeper>());
  int writes = 0;
  unit->arrives = [&] { return ++writes > 1; };
  const auto stopped = chamber->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, FaultKind::timeout);
  EXPECT_EQ(unit->words[9], 0b1101) << "the second step was carried out";
  unit->words[9] = 5;
  writes = 0;
  EXPECT_FALSE(chamber->start());
  EXPECT_EQ(unit->words[9], 5) << "a start ends at the first failure";
}

TEST_F(ChamberCommands, RefusesUnknownCommand) {
  EXPECT_EQ(chamber->perform("defrost").error().kind, FaultKind::refused);
}

TEST_F(ChamberCommands, WritesOneBitAndKeepsTheOthers) {
  ASSERT_TRUE(chamber->perform("acknowledge"));
  EXPECT_EQ(unit->words[9], 0b1101);
}

TEST_F(ChamberCommands, WritesSetPointWithPresentDecimals) {
  ASSERT_TRUE(chamber->send_set_point({40}));
  EXPECT_EQ(unit->words[3], 400);
  unit->words[4] = 2;
  ASSERT_TRUE(chamber->send_set_point({40}));
  EXPECT_EQ(unit->words[3], 4000) << "somebody set two decimals";
  unit->words[5] = 1;
  ASSERT_TRUE(chamber->send_set_point({40}));
  EXPECT_EQ(unit->words[3], 10400) << "… and °F";
  EXPECT_NEAR(chamber->read().value().set_point.value, 40, 1e-9);
}

TEST_F(ChamberCommands, RejectsControllerThatRoundsToWholeDegrees) {
  EXPECT_TRUE(chamber->identify());
  unit->words[4] = 0;
  const auto coarse = chamber->identify();
  ASSERT_FALSE(coarse);
  EXPECT_EQ(coarse.error().kind, FaultKind::mismatch);
  EXPECT_NE(text(coarse.error()).find("(set_point): the controller stores steps of 1 K, expected 0.1 K"),
            std::string::npos)
      << text(coarse.error());
  EXPECT_TRUE(chamber->send_set_point_immediately({23.4})) << "it is made safe all the same";
  EXPECT_EQ(unit->words[3], 23);
}

TEST_F(ChamberCommands, WaitsUntilSetPointIsShown) {
  bool slow = true;
  unit->obey = [&](auto address, auto) {
    if (address == 3 && slow) unit->words[3] = 200;
  };
  time->tick = [&](Duration now) {
    if (now >= std::chrono::milliseconds(500)) unit->words[3] = 300;
  };
  EXPECT_TRUE(chamber->send_set_point({30}));
  EXPECT_LE(time->now(), seconds(1));
  time->tick = [](Duration) {};
  EXPECT_EQ(chamber->send_set_point({31}).error().kind, FaultKind::mismatch);
}

TEST_F(ChamberCommands, DoesNotWriteSetPointOutsideControllerLimits) {
  const auto above = chamber->send_set_point({81});
  ASSERT_FALSE(above);
  EXPECT_EQ(above.error().kind, FaultKind::out_of_range);
  EXPECT_NE(above.error().what.find("81 °C is above the controller's limit of 80 °C"), std::string::npos);
  EXPECT_EQ(chamber->send_set_point({-61}).error().kind, FaultKind::out_of_range);
  EXPECT_TRUE(unit->written.empty());
}

TEST_F(ChamberCommands, ReportsSentinelAsFault) {
  unit->words[1] = 32767;
  const auto state = chamber->read();
  ASSERT_FALSE(state);
  EXPECT_EQ(text(state.error()), "chamber register 1 (air_temperature): sensor broken (7FFF)");
}

TEST_F(ChamberCommands, ReadsSetPointOfAnotherProgram) {
  ASSERT_TRUE(chamber->send_set_point({40}));
  unit->words[3] = 555;
  EXPECT_NEAR(chamber->read().value().set_point.value, 55.5, 1e-9);
}

TEST_F(ChamberCommands, UsesFirstSatisfiedStateRule) {
  unit->words[7] = 1;
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::running);
  unit->words[8] = 0b101;
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::running) << "asked at every second read alone";
  const auto state = chamber->read().value();
  EXPECT_EQ(state.activity, ChamberActivity::door_open);
  EXPECT_EQ(state.alarms, std::vector<std::string>{"door open, water low"});
  EXPECT_FALSE(state.must_stop);
}

TEST_F(ChamberCommands, ListsMostSevereAlarmFirst) {
  unit->words[8] = 0b111;
  const auto state = chamber->read().value();
  EXPECT_EQ(state.activity, ChamberActivity::emergency_stop);
  EXPECT_EQ(state.alarms, (std::vector<std::string>{"somebody pressed it", "door open, water low"}));
  EXPECT_TRUE(state.must_stop);
}

TEST_F(ChamberCommands, StopsReadingRefusedStatusRegister) {
  unit->words[7] = 1;
  unit->refused_from = 8;
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::running);
  const int before = unit->reads;
  (void)chamber->read();
  (void)chamber->read();
  EXPECT_EQ(unit->reads - before, 4 + 5) << "air, set point, decimals, unit; then the state too";
}

TEST_F(ChamberCommands, ReportsMissingRegisters) {
  unit->refused_from = 8;
  ASSERT_TRUE(chamber->inspect());
  EXPECT_EQ(chamber->missing(), std::vector<std::string>{"alarms (exception 2, illegal data address)"});
  unit->refused_from = 0xFFFF;
  ASSERT_TRUE(chamber->inspect());
  EXPECT_EQ(chamber->missing().size(), 1u) << "it is asked for no more";
}

TEST_F(ChamberCommands, RetriesUnansweredStatus) {
  for (const auto kind : {FaultKind::timeout, FaultKind::out_of_range}) {
    SetUp();
    unit->refused_from = 7;
    unit->refusal = {kind, "unit", "exception 6, server device busy"};
    EXPECT_TRUE(chamber->read()) << "air and set point are there";
    const auto state = chamber->inspect();
    ASSERT_FALSE(state) << "nobody knows whether a program runs";
    EXPECT_EQ(state.error().what, "the activity could not be read: unit: exception 6, server device busy");
    EXPECT_TRUE(chamber->missing().empty());
    unit->refused_from = 0xFFFF;
    unit->words[8] = 0b001;
    EXPECT_EQ(chamber->read().value().activity, ChamberActivity::door_open);
  }
}

TEST_F(ChamberCommands, ReportsStatusThatIsBusyForAMinute) {
  unit->refused_from = 8;
  unit->refusal = {FaultKind::timeout, "unit", "exception 6, server device busy"};
  for (int second = 0; second < 30; ++second) EXPECT_TRUE(chamber->read()) << second;
  for (int second = 0; second < 40; ++second) (void)chamber->read();
  const auto state = chamber->read();
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().what,
            "the state and alarms could not be read for a minute: unit: exception 6, server device busy");
}

TEST_F(ChamberCommands, KeepsMostReadingsOnTimeWhenStatusPieceIsSlow) {
  unit->words[7] = 1;
  ASSERT_TRUE(chamber->read());
  unit->loses = [&] { return unit->asked.back() >= 7 && (time->rest(seconds(1)), true); };
  int late = 0;
  for (int second = 0; second < 50; ++second) {
    const auto began = time->now();
    EXPECT_TRUE(chamber->read());
    late += time->now() - began > std::chrono::milliseconds(900) ? 1 : 0;
  }
  EXPECT_EQ(late, 10) << "one in five";
}

TEST_F(ChamberCommands, SendsImmediateSetPointWithoutOtherQueries) {
  ASSERT_TRUE(chamber->send_set_point_immediately({23}));
  EXPECT_EQ(unit->written, (Written{{3, 230}}));
  EXPECT_EQ(unit->asked, (std::vector<std::uint16_t>{4, 5, 3, 4, 5})) << "its decimals and unit, and the read-back";
  EXPECT_TRUE(chamber->send_set_point_immediately({85}))
      << "the controller's limit is not asked for: it may clamp, and is read back";
}

TEST_F(ChamberCommands, SendsImmediateSetPointOnLineThatLosesEverySecondRequest) {
  int requests = 0;
  unit->arrives = [&] { return ++requests % 2 == 0; };
  unit->loses = [&] {
    return requests += requests % 2 == 0 ? 2 : 1, false;
    // The line itself repeats a read.
  };
  EXPECT_TRUE(chamber->send_set_point_immediately({23}));
  EXPECT_EQ(unit->words[3], 230);
}

TEST_F(ChamberCommands, ReadsStatusInTurnOnSlowLine) {
  unit->words[7] = 1;
  unit->each_exchange = [&] { time->rest(std::chrono::milliseconds(130)); };
  int states = 0;
  for (int second = 0; second < 12; ++second) {
    const auto began = time->now();
    const auto state = chamber->read();
    ASSERT_TRUE(state) << text(state.error());
    states += state->activity == ChamberActivity::running ? 1 : 0;
    ASSERT_TRUE(chamber->send_set_point({20.0 + second}));
    EXPECT_LE(time->now() - began, seconds(second == 0 ? 2 : 1)) << "second " << second;
    time->rest(std::max(Duration{}, began + seconds(1) - time->now()));
  }
  EXPECT_GE(states, 8);
}

TEST_F(ChamberCommands, EndsReadingAfterOneSecond) {
  unit->each_exchange = [&] { time->rest(std::chrono::milliseconds(400)); };
  const auto began = time->now();
  EXPECT_EQ(chamber->read().error().kind, FaultKind::timeout);
  EXPECT_LE(time->now() - began, std::chrono::milliseconds(1300)) << "no longer than one exchange beyond";
}

TEST_F(ChamberCommands, ReadsAirDespiteLostStatusPiece) {
  unit->words[7] = 1;
  ASSERT_TRUE(chamber->read());
  unit->loses = [&] { return unit->asked.back() >= 7; };
  for (int second = 0; second < 30; ++second) EXPECT_TRUE(chamber->read()) << second;
  for (int second = 0; second < 40; ++second) (void)chamber->read();
  EXPECT_FALSE(chamber->read()) << "for a minute nobody knows whether it has an alarm";
  unit->loses = [] { return false; };
  EXPECT_TRUE(chamber->read());
}

TEST_F(ChamberCommands, RecoversWhenOverdueStatusArrives) {
  unit->words[7] = 1;
  unit->each_exchange = [&] { time->rest(std::chrono::milliseconds(200)); };
  const auto second = [&] {
    const auto began = time->now();
    auto state = chamber->read();
    time->rest(std::max(Duration{}, began + seconds(1) - time->now()));
    return state;
  };
  ASSERT_TRUE(second());
  unit->loses = [&] { return unit->asked.back() >= 7; };
  for (int i = 0; i < 120; ++i) (void)second();
  EXPECT_FALSE(second());
  unit->loses = [] { return false; };
  for (int i = 0; i < 20; ++i) (void)second();
  const auto state = second();
  ASSERT_TRUE(state) << text(state.error());
  EXPECT_EQ(state->activity, ChamberActivity::running);
}

TEST_F(ChamberCommands, ForgetsActivityAfterSilence) {
  unit->words[7] = 1;
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::running);
  unit->loses = [] { return true; };
  EXPECT_FALSE(chamber->read());
  unit->loses = [&] { return unit->asked.back() >= 7; };
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::unknown);
  unit->loses = [] { return false; };
  EXPECT_EQ(chamber->read().value().activity, ChamberActivity::running);
}

TEST_F(ChamberCommands, ReportsLimitsAndNumberOfExchanges) {
  unit->each_exchange = [&] { time->rest(std::chrono::milliseconds(20)); };
  const auto limits = chamber->limits();
  ASSERT_TRUE(limits);
  EXPECT_EQ(limits->lowest, Celsius{-60});
  EXPECT_EQ(limits->highest, Celsius{80});
  ASSERT_TRUE(chamber->read());
  const auto effort = chamber->effort();
  EXPECT_EQ(effort.each_second, 4);
  EXPECT_EQ(effort.new_set_point, 2);
  EXPECT_EQ(effort.status, 2);
  EXPECT_EQ(effort.longest, std::chrono::milliseconds(20));
}

}  // namespace
}  // namespace gyrotherm::drivers
