// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/grouping.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {
namespace {

using record::GyroKind;
using std::chrono::milliseconds, std::chrono::seconds;

ImportMap every(Duration stretch) {
  ImportMap map = rate_map();
  map.every = stretch;
  return map;
}

ImportMap increments() {
  ImportMap map = rate_map();
  map.units[0].axes[0].kind = GyroKind::pulse_count;
  return map;
}

TEST(Spacing, IncrementCoversTimeSinceRowBefore) {
  const auto rows = read_rows("t,T,w\n0,2,3\n10,2,3\n20,2,3\n500,2,3\n", increments(), "f").value();
  EXPECT_EQ(rows.interval,
            (std::vector<Duration>{milliseconds(10), milliseconds(10), milliseconds(10), milliseconds(480)}));
}

TEST(Spacing, RateCoversUsualSpacing) {
  const auto rows = read_rows("t,T,w\n0,2,3\n10,2,3\n20,2,3\n500,2,3\n", rate_map(), "f").value();
  EXPECT_EQ(rows.interval, std::vector<Duration>(4, milliseconds(10)));
}

TEST(Spacing, PassesRowsImmediatelyAfterHeldRows) {
  const ImportMap map = rate_map();
  std::int64_t handed_on = 0;
  Spacing spacing(map, [&](const ImportedRow& row) -> Result<void> {
    EXPECT_EQ(row.time, milliseconds(10 * handed_on));
    EXPECT_EQ(row.interval, milliseconds(10));
    EXPECT_EQ(row.numbers[1], static_cast<double>(handed_on));
    ++handed_on;
    return {};
  });
  constexpr std::int64_t kRows = 70'000;
  for (std::int64_t i = 0; i < kRows; ++i) {
    const double numbers[] = {20, static_cast<double>(i)};
    ASSERT_TRUE(spacing.push({.time = milliseconds(10 * i), .numbers = numbers}));
    EXPECT_TRUE(handed_on == 0 || i > 60'000);
  }
  EXPECT_EQ(handed_on, kRows);
  ASSERT_TRUE(spacing.finish());
  EXPECT_EQ(handed_on, kRows);
}

/// Returns the map of increments with the counting time in column "s".
ImportMap counted_increments() {
  ImportMap map = increments();
  map.interval_columns = {ColumnName{"s"}};
  map.missing = {""};
  return map;
}

TEST(Spacing, KeepsCountingTimeOfRow) {
  const auto rows =
      read_rows("t,T,w,s\n0,2,3,0.011\n10,2,3,0.009\n500,2,3,0.01\n510,2,3,\n520,2,,0.01\n", counted_increments(), "f");
  ASSERT_TRUE(rows) << text(rows.error());
  ASSERT_EQ(rows->columns.size(), 3u);
  EXPECT_EQ(std::vector(rows->columns[2].begin(), rows->columns[2].begin() + 3),
            (std::vector<double>{0.011, 0.009, 0.01}));
  EXPECT_EQ(rows->columns[1][2], 3);
  EXPECT_TRUE(std::isnan(rows->columns[1][3])) << "without a counting time the increment is missing";
  EXPECT_TRUE(std::isnan(rows->columns[1][4]) && rows->columns[2][4] == 0.01);
}

TEST(Spacing, RefusesImpossibleCountingTime) {
  for (const char* time : {"0", "-1", "1e-12", "1e9"}) {
    const auto rows = read_rows(std::string("t,T,w,s\n0,2,3,0.01\n10,2,3,") + time + "\n", counted_increments(), "f");
    ASSERT_FALSE(rows) << time;
    EXPECT_EQ(rows.error().kind, FaultKind::bad_file);
    EXPECT_EQ(rows.error().where.rfind("f:3:", 0), 0u) << text(rows.error());
  }
}

TEST(Grouping, AddsCountingTimesOfCountedRows) {
  ImportMap map = counted_increments();
  map.every = milliseconds(100);
  std::string table = "t,T,w,s\n";
  for (int i = 0; i < 40; ++i) {
    const bool has_no_time = i == 3 || i >= 30, has_no_number = i == 3 || i == 15;
    table += std::to_string(10 * i) + ",20," + (has_no_number ? "" : "7") + "," + (has_no_time ? "" : "0.0101") + "\n";
  }
  const auto rows = read_rows(table, map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1][0], 63) << "a row without both is not part of the sums";
  EXPECT_NEAR(rows->columns[2][0], 9 * 0.0101, 1e-12);
  EXPECT_TRUE(std::isnan(rows->columns[1][1])) << "an increment is missing from the counting time";
  EXPECT_NEAR(rows->columns[2][1], 10 * 0.0101, 1e-12);
  EXPECT_EQ(rows->columns[1][2], 70);
  EXPECT_TRUE(std::isnan(rows->columns[1][3]) && std::isnan(rows->columns[2][3]));
}

TEST(Grouping, AveragesAvailableRatesAndTemperatures) {
  ImportMap map = every(seconds(1));
  map.missing = {""};
  const auto rows = read_rows("t,T,w\n0,20,1\n500,22,\n900,,3\n1000,24,\n3100,25,9\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->time, (std::vector<Duration>{{}, seconds(1), seconds(3)})) << "a second without rows gives no row";
  EXPECT_EQ(rows->columns[0], (std::vector<double>{21, 24, 25}));
  EXPECT_EQ(rows->columns[1][0], 2);
  EXPECT_TRUE(std::isnan(rows->columns[1][1]));
  EXPECT_EQ(rows->interval, std::vector<Duration>(3, seconds(1)));
}

TEST(Grouping, AddsIncrementsAndIntervals) {
  ImportMap map = increments();
  map.every = milliseconds(100);
  map.missing = {""};
  std::string table = "t,T,w\n";
  for (int i = 0; i < 30; ++i) table += std::to_string(10 * i) + ",20," + (i == 25 ? "" : "7") + "\n";
  const auto rows = read_rows(table, map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1][0], 70);
  EXPECT_EQ(rows->columns[1][1], 70);
  EXPECT_TRUE(std::isnan(rows->columns[1][2])) << "a missing increment makes the sum unknown";
  EXPECT_EQ(rows->interval, std::vector<Duration>(3, milliseconds(100)));
}

TEST(Grouping, AddsOnlyIncrementsIfAnotherUnitHasRates) {
  ImportMap map = increments();
  map.units.push_back(rate_map().units.front());
  map.axis_columns.push_back({.name = "v"});
  map.every = milliseconds(100);
  const auto rows = read_rows("t,T,w,v\n0,20,7,1\n50,20,7,3\n100,20,7,5\n150,20,7,7\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->columns[1], (std::vector<double>{14, 14}));
  EXPECT_EQ(rows->columns[2], (std::vector<double>{2, 6}));
}

TEST(Grouping, ComputesUtcOfStretchStart) {
  ImportMap map = every(seconds(2));
  map.time_form = TimeForm::civil;
  const auto rows = read_rows("t,T,w\n2026-03-01T12:00:01Z,20,1\n2026-03-01T12:00:04Z,20,1\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->utc[0], seconds(1772366401));
  EXPECT_EQ(rows->utc[1], seconds(1772366403));
}

TEST(Grouping, AcceptsRowsLateByOneStretch) {
  ImportMap map = every(seconds(1));
  std::vector<double> sums;
  Grouping grouping(map, [&](const ImportedRow& row) -> Result<void> {
    sums.push_back(row.numbers[1]);
    return {};
  });
  const auto push = [&](int ms, double number) {
    const double numbers[] = {20, number};
    return grouping.push({.time = milliseconds(ms), .numbers = numbers});
  };
  ASSERT_TRUE(push(500, 1) && push(1500, 2) && push(600, 3) && push(2500, 5));
  EXPECT_EQ(sums, std::vector<double>{2}) << "the mean of 1 and 3";
  const auto late = push(700, 1);
  ASSERT_FALSE(late);
  EXPECT_EQ(text(late.error()),
            "the time goes back 0.3 s, expected one after the row before, or out_of_order = \"skip\" in [time]");
  map.out_of_order = OutOfOrder::skip;
  EXPECT_TRUE(push(700, 1));
  EXPECT_EQ(grouping.skipped_rows(), 1u);
}

}  // namespace
}  // namespace gyrotherm::exchange
