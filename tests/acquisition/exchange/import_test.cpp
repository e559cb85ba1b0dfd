// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/import.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/record/record.hpp"
#include "acquisition/record/status.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

using record::read_record, record::read_status, record::Record, tests::TestFolder;

const char* const kSmallMap = R"(schema = "gyrotherm-import/1"
name = "small"
[time]
column = "t"
unit = "s"
[[thermometer]]
name = "die"
column = "T"
[gyro]
column = "w"
kind = "rate"
scale = 2
earth_rate = 8.4
)";

/// Two counters with gates of their own, and a gap of 30 s before the third row.
TEST(Import, UsesCountingTimesOfEachUnit) {
  const TestFolder folder;
  std::ofstream(folder / "counters.toml") << R"(schema = "gyrotherm-import/1"
name = "counters"
[file]
missing = [""]
[time]
column = "t"
unit = "s"
[[gyro]]
name = "one"
column = "n1"
kind = "increment"
scale = 0.5
interval_column = "gate 1"
[[gyro]]
name = "two"
interval_column_number = 6
[[gyro.axis]]
name = "x"
column = "x"
kind = "increment"
scale = 2
[[gyro.axis]]
name = "y"
column = "y"
kind = "increment"
scale = 2
[[gyro]]
name = "three"
column = "n3"
kind = "increment"
scale = 1
)";
  std::ofstream(folder / "counters.csv") << "t,n1,gate 1,x,y,gate 2,n3\n0,10,1.25,1,2,0.5,7\n1,20,0.75,3,4,0.25,8\n"
                                            "31,30,1.000005,5,6,,9\n32,40,,7,8,1,10\n";
  const auto summary = import_record(folder / "counters.csv", folder / "counters.toml", folder / "run.db", "0.2.0");
  ASSERT_TRUE(summary) << text(summary.error());
  EXPECT_EQ(summary->channels.size(), 4u) << "a counting time is no channel";
  const Record record = read_record(folder / "run.db").value();
  ASSERT_EQ(record.units.size(), 3u);
  const auto expect_times = [&](std::size_t unit, const std::vector<double>& expected) {
    for (std::size_t row = 0; row < expected.size(); ++row) {
      const double time = record.units[unit].interval_s[row];
      EXPECT_TRUE(std::abs(time - expected[row]) < 1e-12 || (std::isnan(time) && std::isnan(expected[row])))
          << unit << " " << row << " " << time;
      for (const auto& numbers : record.units[unit].rotation) EXPECT_EQ(std::isnan(numbers[row]), std::isnan(time));
    }
  };
  expect_times(0, {1.25, 0.75, 1.000005, NAN});
  expect_times(1, {0.5, 0.25, NAN, 1});
  expect_times(2, {1, 1, 30, 1});
  EXPECT_EQ(record.units[0].rotation[0][2], 30);
  EXPECT_EQ(record.units[1].rotation[1][3], 8);
}

TEST(Import, MakesFinishedRecordMarkedAsImported) {
  const TestFolder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  std::ofstream(folder / "small.csv") << "t,T,w\n100,20,1.25\n101,21,1.5\n102,22,1\n130,23,1\n";
  const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_TRUE(summary) << text(summary.error());
  EXPECT_EQ(summary->rows, 4u);
  EXPECT_EQ(summary->span, std::chrono::seconds(30));
  EXPECT_EQ(summary->gaps, 1u);
  const Record record = read_record(folder / "run.db").value();
  EXPECT_TRUE(record.finished && record.info.imported && !record.info.virtual_rig);
  EXPECT_EQ(record.info.id.size(), 32u);
  EXPECT_EQ(record.info.rig_text, kSmallMap);
  EXPECT_EQ(record.info.units[0].axes[0].earth_rate, DegreesPerHour{8.4});
  EXPECT_EQ(record.slot, (std::vector<std::int64_t>{0, 1, 2, 3}));
  EXPECT_EQ(record.time_s, (std::vector<double>{0, 1, 2, 30}));
  EXPECT_EQ(record.units[0].rotation[0], (std::vector<double>{1.25, 1.5, 1, 1})) << "stored as it is in the file";
  EXPECT_EQ(record.units[0].interval_s, (std::vector<double>{1, 1, 1, 1}));
  EXPECT_TRUE(std::isnan(record.set_point_c[0]) && std::isnan(record.chamber_air_c[0]));
  ASSERT_EQ(record.events.size(), 2u);
  EXPECT_EQ(record.events[1].event.text, "values of the file: die: 4 values, 20 to 23 °C; gyro: 4 values, 2 to 3 °/h");
  EXPECT_EQ(record.events[0].slot, 3);
  EXPECT_EQ(record.events[0].event.text, "1 gap longer than 10 s, 28 s in all; the first, of 28 s, after row 2");
  EXPECT_TRUE(read_status(folder / "run.db")->finished);
}

TEST(Import, RefusesRowsInReverseOrder) {
  const TestFolder folder;
  std::string map = kSmallMap;
  map.insert(map.find("[[thermometer]]"), "out_of_order = \"skip\"\n");
  std::ofstream(folder / "small.toml") << map;
  std::ofstream rows(folder / "small.csv");
  rows << "t,T,w\n";
  for (int i = 100; i > 0; --i) rows << i << ",20," << i % 7 << "\n";
  rows.close();
  const auto refused = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, folder / "small.csv");
  EXPECT_NE(refused.error().what.find("the times go back in 99 of 100 rows"), std::string::npos)
      << text(refused.error());
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db"));
}

TEST(Import, KeepsMarkOfSimulatedTable) {
  using Titles = std::vector<std::string>;
  const std::string instruments = "SIMULATED: these instruments were virtual: ";
  const std::vector<std::pair<std::string, Titles>> cases{
      {"", {}},
      {"# run 5a of random on virtual\n", {}},
      {"# the air was SIMULATED\n", {}},
      {"# SIMULATED: the instruments were virtual\n", {"all those of small.csv"}},
      {"\xEF\xBB\xBF\"# SIMULATED: the instruments were virtual\",,\r\n", {"all those of small.csv"}},
      {"# gyrotherm 0.2.0\n#SIMULATED\n", {"all those of small.csv"}},
      {"# " + instruments + "chamber, thermometer 2\n", {"chamber", "thermometer 2"}},
      {"# " + instruments + "chamber\x1b[2J\n", {"chamber\\x1b[2J"}},
  };
  for (const auto& [head, titles] : cases) {
    SCOPED_TRACE(head);
    const TestFolder folder;
    std::string map = kSmallMap;
    map.insert(map.find("[time]"), fmt::format("[file]\npreamble = {}\n", std::ranges::count(head, '\n')));
    std::ofstream(folder / "small.toml") << map;
    std::ofstream(folder / "small.csv") << head << "t,T,w\n100,20,1.25\n101,21,1.5\n";
    const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.2.0");
    ASSERT_TRUE(summary) << text(summary.error());
    const auto info = read_record(folder / "run.db").value().info;
    EXPECT_EQ(info.virtual_instruments, titles);
    EXPECT_EQ(is_simulated(info), !titles.empty());
    EXPECT_FALSE(info.virtual_rig);
  }
}

TEST(Import, AsksForUnitOfTimeIfRowsAreFarApart) {
  for (const int step : {60, 1000}) {
    const TestFolder folder;
    std::ofstream(folder / "small.toml") << kSmallMap;
    std::string table = "t,T,w\n";
    for (int i = 0; i < 40; ++i) table += fmt::format("{},{},1\n", step * i, 20 + 0.1 * i);
    std::ofstream(folder / "small.csv") << table;
    const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
    ASSERT_TRUE(summary) << text(summary.error());
    EXPECT_EQ(std::ranges::count(summary->notes, "the rows are 1000 s apart: is the unit in [time] right?"),
              step == 1000 ? 1 : 0);
  }
}

/// Returns the seconds as a time of day.
std::string clock_text(int seconds) {
  return fmt::format("{:02}:{:02}:{:02}", seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
}

/// A time of day is known only modulo one day.
TEST(Import, ComparesTimesOfDayModuloOneDay) {
  struct Case {
    double hours{};
    /// The number in the column of times per second, and the advance of the clock per second.
    double unit = 1, rate = 1;
    bool is_accepted{};
  };
  const TestFolder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  const std::vector<Case> cases{
      {.hours = 12, .is_accepted = true},   {.hours = 23.9, .is_accepted = true},
      {.hours = 24, .is_accepted = true},   {.hours = 24.01, .is_accepted = true},
      {.hours = 60, .is_accepted = true},   {.hours = 71.99, .is_accepted = true},
      {.hours = 1000, .is_accepted = true}, {.hours = 8000, .rate = 1.00001, .is_accepted = true},
      {.hours = 12, .unit = 1.0 / 60},      {.hours = 60, .unit = 1.0 / 60},
      {.hours = 60, .unit = 0.001},         {.hours = 60, .unit = 1.1},
      {.hours = 1000, .unit = 1.0 / 60},    {.hours = 1000, .rate = 1.01}};
  for (const auto& [hours, unit, rate, is_accepted] : cases) {
    SCOPED_TRACE(fmt::format("{} h, unit {}, rate {}", hours, unit, rate));
    std::ofstream table(folder / "small.csv");
    table << "Date,Time,t,T,w\n";
    constexpr int kRows = 1500;
    for (int row = 0; row <= kRows; ++row) {
      const double s = hours * 3600 * row / kRows;
      table << "day," << clock_text(30'000 + static_cast<int>(std::lround(rate * s))) << ","
            << fmt::format("{}", unit * s) << "," << 20 + 0.01 * row << "," << row % 7 << "\n";
    }
    table.close();
    const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.2.0");
    EXPECT_EQ(summary.has_value(), is_accepted) << (summary ? "" : text(summary.error()));
    if (!summary) EXPECT_NE(summary.error().what.find("any number of days"), std::string::npos) << summary.error().what;
    std::filesystem::remove(folder / "run.db");
    std::filesystem::remove(folder / "run.db.sha256");
  }
}

TEST(Import, LeavesNoRecordWhenItFails) {
  const TestFolder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  std::ofstream(folder / "small.csv") << "t,T,w\n100,20,1.25\n101,x,1.5\n";
  const auto bad = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().where, folder / "small.csv" + ":3:5");
  EXPECT_FALSE(std::filesystem::exists(folder / "run.db"));
  EXPECT_EQ(import_record(folder / "none.csv", folder / "small.toml", folder / "run.db", "0.1.0").error().kind,
            FaultKind::bad_file);
}

TEST(Import, RefusesScaleThatMakesNumberInfinite) {
  const TestFolder folder;
  for (const std::string every : {"", "every = \"1 s\"\n"})
    for (const std::string row : {"101,1e307,1", "101,20,1e308"}) {
      std::string map = kSmallMap;
      map.replace(map.find("column = \"T\""), 12, "column = \"T\"\nscale = 100");
      map.insert(map.find("[[thermometer]]"), every);
      std::ofstream(folder / "small.toml") << map;
      std::ofstream(folder / "small.csv") << "t,T,w\n100,20,1\n" << row << "\n";
      const auto bad = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
      ASSERT_FALSE(bad) << row;
      EXPECT_EQ(bad.error().where, folder / "small.csv" + ":3:1") << row;
      EXPECT_NE(bad.error().what.find("too large with the map"), std::string::npos) << bad.error().what;
      EXPECT_FALSE(std::filesystem::exists(folder / "run.db"));
    }
}

TEST(Import, NeverOverwritesRecord) {
  const TestFolder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  std::ofstream(folder / "small.csv") << "t,T,w\n1,2,3\n";
  ASSERT_TRUE(import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0"));
  const auto again = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, FaultKind::storage);
  EXPECT_TRUE(read_record(folder / "run.db"));
}

TEST(Import, KeepsUtcWhenFileHasIt) {
  const TestFolder folder;
  std::string map = kSmallMap;
  map.replace(map.find("\"s\""), 3, "\"iso\"");
  std::ofstream(folder / "small.toml") << map;
  std::ofstream(folder / "small.csv") << "t,T,w\n2026-03-01T12:00:00Z,20,1\n2026-03-01T12:00:01Z,21,2\n";
  ASSERT_TRUE(import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0"));
  const Record record = read_record(folder / "run.db").value();
  EXPECT_EQ(record.info.started_utc, std::chrono::seconds(1772366400));
  EXPECT_EQ(record.last_utc, std::chrono::seconds(1772366401));
  EXPECT_TRUE(record.info.imported);
}

TEST(Import, WritesMoreRowsThanOneTransaction) {
  const TestFolder folder;
  std::ofstream(folder / "small.toml") << kSmallMap;
  {
    std::ofstream table(folder / "small.csv");
    table << "t,T,w\n";
    for (int row = 0; row < 250'000; ++row) table << row << ",20.5," << row % 7 << "\n";
  }
  const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.1.0");
  ASSERT_TRUE(summary) << text(summary.error());
  const Record record = read_record(folder / "run.db").value();
  ASSERT_EQ(record.slot.size(), 250'000u);
  EXPECT_EQ(record.units[0].rotation[0][249'999], 249'999 % 7);
  EXPECT_EQ(record.events.size(), 2u) << "the die is always 20.5 °C, and the values";
}

/// No import makes rows finer.
TEST(Import, RefusesEveryBelowSpacingOfRows) {
  struct Case {
    double spacing_s;
    const char* every;
    bool is_accepted;
  };
  for (const auto& [spacing_s, every, is_accepted] :
       {Case{10, "1 s", false}, Case{10, "9 s", false}, Case{10, "10 s", true}, Case{10, "20 s", true},
        Case{1.01, "1 s", true}, Case{0.1, "50 ms", false}, Case{0.1, "1 s", true}}) {
    SCOPED_TRACE(fmt::format("{} s, every {}", spacing_s, every));
    const TestFolder folder;
    std::string map = kSmallMap, table = "t,T,w\n";
    map.insert(map.find("[[thermometer]]"), fmt::format("every = \"{}\"\n", every));
    for (int row = 0; row < 60; ++row)
      table += fmt::format("{},{},{}\n", spacing_s * row, 20 + row % 7, 1.25 + row % 3);
    std::ofstream(folder / "small.toml") << map;
    std::ofstream(folder / "small.csv") << table;
    const auto summary = import_record(folder / "small.csv", folder / "small.toml", folder / "run.db", "0.2.0");
    EXPECT_EQ(summary.has_value(), is_accepted) << (summary ? "" : text(summary.error()));
    if (summary) continue;
    EXPECT_EQ(summary.error().kind, FaultKind::bad_file);
    EXPECT_EQ(summary.error().where, folder / "small.csv");
  }
}

}  // namespace
}  // namespace gyrotherm::exchange
