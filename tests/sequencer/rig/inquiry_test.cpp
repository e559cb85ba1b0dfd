// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/inquiry.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "core/file.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "sequencer/rig/rig.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/loopback_server.hpp"

namespace gyrotherm::rig {
namespace {

TEST(Inquiry, OrdersRoundTripTimes) {
  VirtualClock clock;
  int call = 0;
  const auto trips = time_calls(
      [&]() -> Result<void> {
        clock.advance(std::chrono::milliseconds(++call == 3 ? 100 : call));
        return {};
      },
      clock);
  EXPECT_EQ(call, 10);
  EXPECT_EQ(trips.least, std::chrono::milliseconds(1));
  EXPECT_EQ(trips.median, std::chrono::microseconds(6500));
  EXPECT_EQ(trips.most, std::chrono::milliseconds(100));
  EXPECT_EQ(text(trips), "10 reads: 1.000, 6.500, 100.000 ms (least, median, most)");
}

TEST(Inquiry, TimesOnlyCallsThatSucceed) {
  for (const int failing : {0, 1, 4, 5, 9, 10}) {
    VirtualClock clock;
    int call = 0;
    const auto trips = time_calls(
        [&]() -> Result<void> {
          if (++call > failing) return clock.advance(std::chrono::milliseconds(20)), Result<void>{};
          return failure(FaultKind::timeout, "HX-16", "no reply");
        },
        clock);
    EXPECT_EQ(call, 10);
    EXPECT_EQ(trips.failed, static_cast<std::size_t>(failing));
    EXPECT_EQ(trips.least, std::chrono::milliseconds(failing == 10 ? 0 : 20)) << "a failure takes no time";
    EXPECT_EQ(trips.median, trips.least);
    EXPECT_EQ(text(trips).find("WARNING") != std::string::npos, failing > 0);
    const auto good = check_calls(trips);
    EXPECT_EQ(good.has_value(), failing < 5) << failing;
    if (!good) EXPECT_EQ(good.error().kind, FaultKind::timeout);
  }
}

/// A chamber in a mode that its map does not name.
class OddChamber final : public drivers::Chamber {
 public:
  explicit OddChamber(std::string mode) : mode_(std::move(mode)) {}
  Result<std::string> identify() override { return std::string("Odd"); }
  Result<ChamberState> read() override { return ChamberState{.air = {20}, .set_point = {20}}; }
  Result<void> send_set_point(Celsius) override { return {}; }
  Result<void> start() override { return {}; }
  Result<void> stop() override { return {}; }
  std::string unmatched_state() const override { return mode_; }

 private:
  std::string mode_;
};

TEST(Inquiry, WarnsWhenNoStateFits) {
  VirtualClock clock;
  OddChamber odd("mode 7"), known("");
  EXPECT_NE(query_chamber(odd, clock).value().find("WARNING: no [[state]] of its map fits mode 7;"), std::string::npos);
  EXPECT_EQ(query_chamber(known, clock).value().find("WARNING"), std::string::npos);
}

/// A thermometer with two inputs. The second is open, and the first answers only `readings` times.
class FailingThermometer final : public drivers::Thermometer {
 public:
  explicit FailingThermometer(int readings) : left_(readings) {}
  Result<std::string> identify() override { return std::string("FAILING,1"); }
  std::vector<Result<Celsius>> read() override {
    const auto open = failure(FaultKind::out_of_range, "input 2", "open input");
    if (left_-- > 0) return {Celsius{20}, open};
    return {failure(FaultKind::timeout, "input 1", "no reply"), open};
  }

 private:
  int left_;
};

TEST(Inquiry, RefusesInstrumentThatBecomesSilent) {
  VirtualClock clock;
  for (const auto& [readings, is_good, warns] : {std::tuple(11, true, false), std::tuple(7, true, true),
                                                 std::tuple(6, false, false), std::tuple(1, false, false)}) {
    FailingThermometer thermometer(readings);
    const auto answer = query_thermometer(thermometer, {"A", "B"}, clock);
    EXPECT_EQ(answer.has_value(), is_good) << readings;
    if (answer) EXPECT_EQ(answer->find("of 10 reads failed: input 1: no reply") != std::string::npos, warns) << *answer;
    if (!answer) EXPECT_EQ(answer.error().kind, FaultKind::timeout);
  }
}

/// A thermometer whose reading takes `time` by the clock.
class SlowThermometer final : public drivers::Thermometer {
 public:
  SlowThermometer(VirtualClock& clock, Duration time) : clock_(clock), time_(time) {}
  Result<std::string> identify() override { return std::string("SLOW,1"); }
  std::vector<Result<Celsius>> read() override {
    clock_.advance(time_);
    return {Celsius{20}};
  }

 private:
  VirtualClock& clock_;
  Duration time_;
};

TEST(Inquiry, RefusesScanLongerThanFourFifthsOfASecond) {
  VirtualClock clock;
  SlowThermometer quick(clock, std::chrono::milliseconds(800)), slow(clock, std::chrono::milliseconds(810));
  const auto good = query_thermometer(quick, {"A"}, clock), bad = query_thermometer(slow, {"A"}, clock);
  EXPECT_EQ(good.value(), "SLOW,1, A 20.000 °C; 10 reads: 800.000, 800.000, 800.000 ms (least, median, most)");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().kind, FaultKind::timeout);
  EXPECT_TRUE(bad.error().what.starts_with("SLOW,1: a reading takes 0.810 s; a run reads once a second, and 0.8 s fit"))
      << bad.error().what;
}

TEST(Inquiry, WarnsWhenAirIsFarFromEveryThermometer) {
  EXPECT_EQ(describe_air_mismatch({20}, {}), "");
  EXPECT_EQ(describe_air_mismatch({20}, {{-40}, {33}}), "") << "one thermometer near the air is enough";
  EXPECT_EQ(describe_air_mismatch({20}, {{35}}), "");
  const auto hot = describe_air_mismatch({20}, {{60}, {35.5}});
  EXPECT_NE(hot.find("WARNING: the chamber shows air of 20.0 °C, the nearest thermometer 35.5 °C;"), std::string::npos)
      << hot;
  for (const double celsius : {23.0, -40.0, 85.0, 12.0}) {
    const auto warning = describe_air_mismatch({celsius * 1.8 + 32}, {{celsius - 0.5}, {celsius + 1}});
    EXPECT_EQ(warning.find("as if the chamber showed °F") != std::string::npos, celsius != -40.0) << warning;
  }
}

TEST(Inquiry, ReportsAlarmsThatAreNotMonitored) {
  const auto map = drivers::parse_register_map(R"(schema = "gyrotherm-chamber/1"
name = "oven"
vendor = "test"
source = "none"
[link]
[[register]]
name = "air_temperature"
address = 1
type = "s16"
[[register]]
name = "set_point"
address = 2
type = "s16"
access = "rw"
[[register]]
name = "door"
address = 3
type = "u16"
codes = { shut = 0, open = 1 }
[[alarm]]
severity = "stop"
register = "door"
is = "open"
)",
                                               "map.toml");
  ASSERT_TRUE(map) << text(map.error());
  auto without_door = std::make_unique<tests::FakeRegisters>();
  without_door->words = {{1, 20}, {2, 20}};
  const auto chamber = make_modbus_chamber(*map, std::move(without_door));
  const auto answer = query_chamber(*chamber, VirtualClock());
  ASSERT_TRUE(answer) << text(answer.error());
  EXPECT_NE(
      answer->find(
          "WARNING: not monitored, because the unit does not report it: door (exception 2, illegal data address)"),
      std::string::npos)
      << *answer;
}

TEST(Inquiry, PrintsVerifiedAndUnverifiedPartsOfChamberMap) {
  for (const auto& [name, verified, not_verified] :
       {std::tuple{"watlow_f4t", "Watlow F4T, control loops without cascade", "what switches the chamber's power"},
        std::tuple{"watlow_f4", "Watlow F4", "whether the unit ramps set points by itself"},
        std::tuple{"binder_mb1", "", "make and model: no source names a register that shows them"},
        std::tuple{"csz_ezt570i", "the set point is that of the air (product control off)", "make and model"}}) {
    auto rig_text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml").value();
    const std::string map = "../chambers/virtual.toml";
    ASSERT_NE(rig_text.find(map), std::string::npos);
    rig_text.replace(rig_text.find(map), map.size(), fmt::format("../chambers/{}.toml", name));
    const auto file = parse_rig(rig_text, GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml");
    ASSERT_TRUE(file) << text(file.error());
    const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
    ASSERT_TRUE(rig) << text(rig.error());
    const auto chamber = (*rig)->query_instruments().front();
    ASSERT_TRUE(chamber) << text(chamber.error());
    const auto list = chamber->find("; NOT verified: ");
    ASSERT_NE(list, std::string::npos) << *chamber;
    EXPECT_NE(chamber->find(not_verified, list), std::string::npos) << *chamber;
    EXPECT_LT(chamber->find(verified), list) << *chamber;
  }
}

TEST(Inquiry, PrintsIdentityAndReadingsOfEveryInstrument) {
  const auto file = read_rig(GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-mixed.toml");
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->query_instruments();
  ASSERT_EQ(answers.size(), 4u);
  const auto expect = [&](std::size_t index, const std::string& part) {
    ASSERT_TRUE(answers[index]) << text(answers[index].error());
    EXPECT_NE(answers[index]->find(part), std::string::npos) << *answers[index];
  };
  expect(0, "chamber: ");
  expect(0, "10 reads: ");
  expect(1, "thermometer 1: LSCI,MODEL218");
  expect(2, "shell ");
  expect(3, "gyro: kvh-17xx-a frames, ");
  expect(3, "2 frames seen, 0 lost, 0 bad");
}

TEST(Inquiry, NamesInstrumentOnceInFault) {
  const auto place = [](const std::string& title, const std::string& where) {
    return name_instrument(title, {FaultKind::timeout, where, "no reply"}).where;
  };
  EXPECT_EQ(place("gyro", ""), "gyro");
  EXPECT_EQ(place("gyro", "gyro"), "gyro");
  EXPECT_EQ(place("gyro", "gyro: stim300"), "gyro: stim300");
  EXPECT_EQ(place("chamber", "chamber stop"), "chamber stop");
  EXPECT_EQ(place("thermometer 1", "thermometer 10"), "thermometer 1: thermometer 10");
  EXPECT_EQ(place("supply 2", "tcp 10.0.0.9:5025"), "supply 2: tcp 10.0.0.9:5025");
}

/// Ports of a real rig on the loopback interface. The ports below 10 are closed.
struct LoopbackPorts {
  std::uint16_t chamber = 1, gyro = 4;
};

/// Prepares the rig and returns the fault.
Fault fault_of_preparation(const LoopbackPorts& ports) {
  const std::string folder = GYROTHERM_SOURCE_DIR "/profiles/rigs/";
  auto lines = read_text_file(folder + "example-f4t-lakeshore-kvh.toml").value();
  const std::string key = "\nline = \"";
  auto at = lines.find(key);
  for (const auto port : {ports.chamber, std::uint16_t{2}, std::uint16_t{3}, ports.gyro}) {
    at += key.size();
    lines.replace(at, lines.find('"', at) - at, fmt::format("tcp://127.0.0.1:{}", port));
    at = lines.find(key, at);
  }
  EXPECT_EQ(at, std::string::npos);
  const auto file = parse_rig(lines, folder + "mine.toml");
  EXPECT_TRUE(file) << text(file.error());
  if (!file) return {};
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  EXPECT_TRUE(rig) << text(rig.error());
  const auto prepared = (*rig)->prepare(Celsius{20});
  EXPECT_FALSE(prepared);
  return prepared ? Fault{} : prepared.error();
}

TEST(Preparation, NamesInstrumentThatCannotBeReached) {
  const auto gyro = fault_of_preparation({});
  EXPECT_EQ(gyro.kind, FaultKind::disconnected);
  EXPECT_TRUE(gyro.where.starts_with("gyro: tcp 127.0.0.1:4")) << gyro.where;
  EXPECT_NE(gyro.what.find("check its power"), std::string::npos) << gyro.what;

  const drivers::LoopbackServer silent([](auto) { return drivers::Answer{}; });
  const auto chamber = fault_of_preparation({.gyro = silent.address().port});
  EXPECT_EQ(chamber.kind, FaultKind::disconnected);
  EXPECT_TRUE(chamber.where.starts_with("chamber: ")) << chamber.where;
  EXPECT_NE(chamber.what.find(" on tcp://127.0.0.1:1)"), std::string::npos) << chamber.what;
}

/// The map belongs to another controller, which refuses each register.
TEST(Preparation, NamesChamberWhoseMapIsWrong) {
  const drivers::LoopbackServer silent([](auto) { return drivers::Answer{}; });
  const drivers::LoopbackServer another([](std::span<const std::byte> request) {
    constexpr std::size_t kHeader = 7;
    constexpr auto kException = std::byte{0x80}, kIllegalAddress = std::byte{2};
    std::vector<std::byte> reply(request.begin(), request.begin() + kHeader + 1);
    reply[kHeader - 2] = std::byte{3};  // unit, function and exception
    reply[kHeader] |= kException;
    reply.push_back(kIllegalAddress);
    return drivers::Answer{reply};
  });
  const auto chamber = fault_of_preparation({.chamber = another.address().port, .gyro = silent.address().port});
  EXPECT_EQ(chamber.kind, FaultKind::refused);
  EXPECT_TRUE(chamber.where.starts_with("chamber: modbus 127.0.0.1")) << chamber.where;
  EXPECT_NE(chamber.what.find("check that the map fits"), std::string::npos) << chamber.what;
}

TEST(Inquiry, ReadsGyroWithoutClockByRigClock) {
  const std::string place = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-mixed.toml";
  auto rig_text = read_text_file(place).value();
  const std::string was = "kvh-17xx-a.toml";
  rig_text.replace(rig_text.find(was), was.size(), "hg4930.toml");
  const auto file = parse_rig(rig_text, place);
  ASSERT_TRUE(file) << text(file.error());
  const auto rig = Rig::assemble(*file, {.seed = {}, .elapsed = {}, .replay = {}});
  ASSERT_TRUE(rig) << text(rig.error());
  const auto answers = (*rig)->query_instruments();
  ASSERT_TRUE(answers.at(3)) << text(answers.at(3).error());
  EXPECT_NE(answers.at(3)->find("mean of 2.000 s"), std::string::npos) << *answers.at(3);
}

TEST(Inquiry, ComparesRateWithEarthRate) {
  struct Case {
    double measured, earth, bias, one_count;
    bool warns;
  };
  const std::vector<Case> cases{
      {10.64, 10.64, 0, 0, false},  {15.9, 10.64, 0, 0, false},                               // a factor below 1.5
      {16.1, 10.64, 0, 0, true},    {5.2, 10.64, 0, 0, true},   {-10.64, 10.64, 0, 0, true},  // the other sign
      {859, 10.64, 20, 0, true},                                                              // degrees for radians
      {15000, 10.64, 500, 0, true}, {25, 10.64, 20, 0, false},  {1.4, 0, 0, 0, false},       {1.6, 0, 0, 0, true},
      {1.6, 0, 0, 0.2, false},      {0, -11.2, 0, 0, true},     {-11.3, -11.2, 0, 0, false},
  };
  for (const auto& [measured, earth, bias, one_count, warns] : cases) {
    const auto line = describe_rate("z", {measured}, DegreesPerHour{earth}, {bias}, {one_count});
    EXPECT_EQ(line.find("WARNING") != std::string::npos, warns) << line;
    EXPECT_TRUE(line.starts_with(fmt::format("z {:.2f} °/h (Earth rate {:.2f} °/h)", measured, earth))) << line;
  }
  EXPECT_EQ(describe_rate("rate", {12}, std::nullopt, {0}, {0}),
            "rate 12.00 °/h (Earth rate unknown: the rig file has no latitude)");
}

/// A gyro with a constant rate. It sends the second of two values.
class SteadyGyro final : public drivers::Gyro {
 public:
  explicit SteadyGyro(std::int64_t counts, std::vector<double> values) : counts_(counts), values_(std::move(values)) {}
  Result<GyroCount> read(Duration) override { return GyroCount{{counts_}, kSecond, values_}; }

 private:
  std::int64_t counts_;
  std::vector<double> values_;
};

Result<RigFile> mixed_rig_with(const std::string& stream, const std::string& keys) {
  const std::string place = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual-mixed.toml";
  auto rig_text = read_text_file(place).value();
  const std::string was = "kvh-17xx-a.toml\"";
  rig_text.replace(rig_text.find(was), was.size(), stream + ".toml\"\n" + keys + "\n");
  return parse_rig(rig_text, place);
}

std::string print_answers(const RigFile& rig, std::int64_t counts, const std::vector<double>& values) {
  SteadyGyro gyro(counts, values);
  const auto answer = query_gyro(gyro, rig.gyro_lines[0], rig.units, false, [] {});
  return answer ? *answer : text(answer.error());
}

TEST(Inquiry, PrintsRateOfGyroButNoMissingValue) {
  const auto rig = mixed_rig_with("stim300", "");
  ASSERT_TRUE(rig) << text(rig.error());
  const auto line = print_answers(*rig, 10'640'000, {std::nan(""), 1.5, std::nan("")});
  EXPECT_NE(line.find("rate 10.64 °/h (Earth rate 10.64 °/h)"), std::string::npos) << line;
  EXPECT_EQ(line.find("nan"), std::string::npos) << line;
  EXPECT_EQ(line.find("acceleration_x"), std::string::npos) << line;
  EXPECT_NE(line.find("acceleration_y 1.5 g"), std::string::npos) << line;
  EXPECT_EQ(line.find("WARNING"), std::string::npos) << line;
}

TEST(Inquiry, WarnsWhenRateExceedsLargestBias) {
  for (const auto& [stream, keys, counts, warns] :
       std::vector<std::tuple<std::string, std::string, std::int64_t, bool>>{
           {"kvh-17xx-a", "", 859'000'000, true},                              // degrees for radians
           {"kvh-17xx-a", "", 25'000'000, false},                              // a bias of its class
           {"kvh-17xx-a", "largest_bias_deg_per_h = 0.01", 25'000'000, true},  // a better unit
           {"vectornav", "", 400'000'000, false},                              // the stream's own class
           {"vectornav", "largest_bias_deg_per_h = 10", 400'000'000, true},
           {"stim300", "", -600'000'000, true}}) {
    const auto rig = mixed_rig_with(stream, keys);
    ASSERT_TRUE(rig) << text(rig.error());
    const auto line = print_answers(*rig, counts, {});
    EXPECT_EQ(line.find("WARNING") != std::string::npos, warns) << line;
  }
}

TEST(Inquiry, PrintsUnverifiedSettings) {
  const auto rig = mixed_rig_with("kvh-17xx-a", "");
  ASSERT_TRUE(rig) << text(rig.error());
  const auto line = print_answers(*rig, 0, {});
  EXPECT_NE(line.find("settings verified: output format: A, unit of rotation: radians"), std::string::npos) << line;
  EXPECT_NE(line.find("settings NOT verified: filter: as found"), std::string::npos) << line;
  const auto silent = mixed_rig_with("kvh-17xx-a", "listen_only = true");
  ASSERT_TRUE(silent) << text(silent.error());
  EXPECT_NE(print_answers(*silent, 0, {}).find("settings NOT verified: output format: A (the gyro was not queried)"),
            std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::rig
