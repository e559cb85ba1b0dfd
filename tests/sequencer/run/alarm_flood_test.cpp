// SPDX-License-Identifier: Apache-2.0
/// Half an hour with a starved machine or a flaky cable: the list has at most one row per cause and instrument, one
/// acknowledgement covers all, and the record has every occurrence.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "tests/support/bench_rig.hpp"

namespace gyrotherm::run {
namespace {

const char* kLongHold = "[[segment]]\nkind = \"hold\"\nat = \"20 °C\"\ntime = \"2 h\"\n";
constexpr int kHalfAnHour = 1800;

void set_addresses(rig::RigFile& rig) {
  rig.chamber_line = "tcp://10.0.0.5:502";
  rig.thermometers.resize(2);
  rig.thermometers[0].line = "tcp://10.0.0.6:502";
  rig.thermometers[1].line = "serial:/dev/ttyUSB0";
  for (std::size_t i = 0; i < 9; ++i) {
    const auto channel = std::string(1, static_cast<char>('A' + i));
    auto& scanner = rig.thermometers[i < 4 ? 0 : 1];
    scanner.channels.push_back(channel);
    scanner.calibrated.emplace_back().name = channel;
    rig.limits.channels.push_back(channel);
  }
  rig.limits.instruments = {{.name = "thermometer 1", .columns = {0, 1, 2, 3}},
                            {.name = "thermometer 2", .columns = {4, 5, 6, 7, 8}}};
  rig.limits.units = {{.name = "gyro", .thermometers = {0, 1, 2, 3, 4, 5, 6, 7, 8}}};
  rig.gyro_lines.push_back({.line = "serial:/dev/ttyUSB1", .frame = {}, .stream = {}, .shares = {{.unit = 0}}});
}

class AlarmFlood : public testing::Test {
 protected:
  using Silence = std::function<void(bool silent)>;

  int between(int low, int high) { return std::uniform_int_distribution(low, high)(random_); }

  /// Simulates silence for 1 to 12 s, then answers for 3 to 40 s, for half an hour.
  void simulate_dropouts(const Silence& silence, int most_late) {
    for (int second = 0; second < kHalfAnHour;) {
      const auto late = most_late > 0 ? between(1, most_late) : 0;
      if (late > 0) bench_.late(late);
      const auto silent = between(1, 12), well = between(3, 40);
      silence(true);
      seconds(silent);
      silence(false);
      seconds(well);
      second += late + silent + well;
    }
  }
  void seconds(int count) {
    for (; count > 0; --count) {
      bench_.seconds(1);
      check_rows();
    }
  }
  /// Checks that the list has one row per tag, in any state.
  void check_rows() {
    std::set<std::string> tags;
    most_rows_ = std::max(most_rows_, record::count_unacknowledged(bench_.record().alarms().list()));
    for (const auto& alarm : bench_.record().alarms().list())
      EXPECT_TRUE(tags.insert(alarm.tag()).second) << alarm.tag();
  }
  /// Checks that the record has each occurrence as a separate event.
  void expect_event_per_occurrence() {
    std::int64_t events = 0;
    for (const auto& event : bench_.record().events)
      events +=
          (event.kind == EventKind::interlock || event.kind == EventKind::fault) && !event.about.interlock.empty();
    EXPECT_EQ(bench_.record().alarms().count().occurrences, events);
    EXPECT_GT(events, 20) << "this is a flood";
  }
  void expect_one_acknowledgement() {
    std::int64_t roots = 0, consequences = 0;
    for (const auto& alarm : bench_.record().alarms().unacknowledged())
      ++(alarm.suppressed_by.empty() ? roots : consequences);
    const auto answer = bench_.run_controller().carry_out(
        *control::make_request("acknowledge", "all the cable was replaced"), "ada (uid 1000)");
    EXPECT_TRUE(answer.done);
    EXPECT_TRUE(answer.text.starts_with(fmt::format("{} alarm", roots))) << answer.text;
    EXPECT_EQ(answer.text.find(fmt::format("and {} consequence", consequences)) != std::string::npos, consequences > 0)
        << answer.text;
    EXPECT_EQ(record::count_unacknowledged(bench_.record().alarms().list()), 0u);
    EXPECT_EQ(bench_.record().alarms().count().unacknowledged, 0);
    seconds(120);
    EXPECT_TRUE(bench_.record().alarms().list().empty());
  }
  [[nodiscard]] std::string rows() {
    std::string text;
    for (const auto& alarm : bench_.record().alarms().list())
      text += fmt::format("{} ×{} {} under \"{}\"\n", alarm.tag(), alarm.count, describe_alarm_state(alarm),
                          alarm.suppressed_by);
    return text;
  }

  std::mt19937 random_{49};
  tests::Bench bench_{kLongHold, set_addresses};
  std::size_t most_rows_ = 0;
};

TEST_F(AlarmFlood, OfStarvedMachineHasOneRow) {
  auto& io = bench_.instruments();
  simulate_dropouts(
      [&](bool silent) {
        bench_.chamber().silent = silent;
        io.gyro_silent = silent;
        io.silent_thermometers.clear();
        for (std::size_t i = 0; i < 9 && silent; ++i) io.silent_thermometers.push_back(i);
      },
      4);
  EXPECT_EQ(most_rows_, 1u) << rows();
  expect_event_per_occurrence();
  expect_one_acknowledgement();
}

TEST_F(AlarmFlood, OfIntermittentScannerCableHasOneRow) {
  simulate_dropouts(
      [&](bool silent) {
        bench_.instruments().silent_thermometers =
            silent ? std::vector<std::size_t>{4, 5, 6, 7, 8} : std::vector<std::size_t>{};
      },
      0);
  EXPECT_EQ(most_rows_, 1u) << rows();
  expect_event_per_occurrence();
  expect_one_acknowledgement();
}

TEST_F(AlarmFlood, OfIntermittentChamberCableHasOneRow) {
  simulate_dropouts([&](bool silent) { bench_.chamber().silent = silent; }, 0);
  EXPECT_EQ(most_rows_, 1u) << rows();
  expect_event_per_occurrence();
  expect_one_acknowledgement();
}

TEST_F(AlarmFlood, OfIntermittentGyroCableHasOneRow) {
  simulate_dropouts([&](bool silent) { bench_.instruments().gyro_silent = silent; }, 0);
  EXPECT_EQ(most_rows_, 1u) << rows();
  expect_event_per_occurrence();
  expect_one_acknowledgement();
}

/// Two cables at once are two causes.
TEST_F(AlarmFlood, OfTwoCablesHasTwoRows) {
  simulate_dropouts(
      [&](bool silent) {
        bench_.instruments().gyro_silent = silent;
        bench_.instruments().silent_thermometers =
            silent ? std::vector<std::size_t>{0, 1, 2, 3} : std::vector<std::size_t>{};
      },
      0);
  EXPECT_EQ(most_rows_, 2u) << rows();
  expect_event_per_occurrence();
  expect_one_acknowledgement();
}

}  // namespace
}  // namespace gyrotherm::run
