// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/row_order.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/acquisition/exchange/foreign.hpp"

namespace gyrotherm::exchange {
namespace {

ImportMap map_with(OutOfOrder way, bool increments = false) {
  ImportMap map = rate_map();
  map.time_unit = kSecond;
  map.out_of_order = way;
  if (increments) map.units[0].axes[0].kind = record::GyroKind::pulse_count;
  return map;
}

std::string make_table(const std::vector<double>& times) {
  std::string table = "t,T,w\n";
  for (std::size_t i = 0; i < times.size(); ++i) table += std::to_string(times[i]) + ",20," + std::to_string(i) + "\n";
  return table;
}

std::vector<double> ramp(std::size_t rows) {
  std::vector<double> times(rows);
  std::iota(times.begin(), times.end(), 0.);
  return times;
}

TEST(RowOrder, LeavesOutFewestRows) {
  for (const std::vector<std::pair<std::size_t, double>>& glitches :
       {std::vector<std::pair<std::size_t, double>>{{50, 1e6}},
        {{50, 1e6}, {51, 1e6 + 1}, {52, 1e6 + 2}},
        {{50, 3}},
        {{10, 500}, {90, 4}, {150, 1e5}}}) {
    auto times = ramp(200);
    for (const auto& [row, time] : glitches) times[row] = time;
    const auto rows = read_rows(make_table(times), map_with(OutOfOrder::skip), "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_EQ(rows->time.size(), 200 - glitches.size());
    EXPECT_EQ(rows->time.back(), std::chrono::seconds(199));
    EXPECT_EQ(rows->notes.front(),
              (glitches.size() == 1 ? "1 row was left out because its"
                                    : std::to_string(glitches.size()) + " rows were left out because their") +
                  std::string(" time was not after the previous row's"));
  }
}

TEST(RowOrder, AddsIncrementsOfRowsLeftOut) {
  for (const std::vector<std::size_t>& glitches : {std::vector<std::size_t>{50}, {50, 51, 52}, {7, 80, 120}}) {
    auto times = ramp(200);
    for (const std::size_t row : glitches) times[row] = 1;
    const auto rows = read_rows(make_table(times), map_with(OutOfOrder::skip, true), "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_EQ(std::accumulate(rows->columns[1].begin(), rows->columns[1].end(), 0.), 199 * 100) << "none is lost";
  }
}

TEST(RowOrder, AddsCountingTimesOfRowsLeftOut) {
  ImportMap map = map_with(OutOfOrder::skip, true);
  map.interval_columns = {ColumnName{"s"}};
  const auto rows = read_rows("t,T,w,s\n0,20,1,0.5\n1000,20,2,0.25\n500,20,4,0.125\n2000,20,8,1\n", map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  ASSERT_EQ(rows->time.size(), 3u);
  double increments = 0, seconds = 0;
  for (std::size_t row = 0; row < rows->time.size(); ++row) {
    increments += rows->columns[1][row];
    seconds += rows->columns[2][row];
  }
  EXPECT_EQ(increments, 15);
  EXPECT_EQ(seconds, 1.875);
}

TEST(RowOrder, RefusesImpossibleCountingTimes) {
  ImportMap map = map_with(OutOfOrder::refuse, true);
  map.interval_columns = {ColumnName{"s"}};
  for (const char* wrong : {"0", "-1", "-1e300", "1e300", "1e-12", "-1e10", "3.2e8"})
    EXPECT_EQ(read_rows(fmt::format("t,T,w,s\n0,20,1,0.5\n1,20,2,{}\n", wrong), map, "f").error().where, "f:3:1")
        << wrong;
  EXPECT_TRUE(read_rows("t,T,w,s\n0,20,1,0.5\n1,20,2,3.1e8\n", map, "f"));
}

TEST(RowOrder, AddsIncrementsOfEqualTimesWhenRowsAreCombined) {
  ImportMap map = map_with(OutOfOrder::refuse, true);
  map.every = std::chrono::seconds(2);
  std::vector<double> times;
  for (int i = 0; i < 100; ++i) times.push_back(i / 10);  // NOLINT: whole seconds
  const auto rows = read_rows(make_table(times), map, "f");
  ASSERT_TRUE(rows) << text(rows.error());
  EXPECT_EQ(rows->time.size(), 5u);
  EXPECT_EQ(std::accumulate(rows->columns[1].begin(), rows->columns[1].end(), 0.), 99 * 50);
}

TEST(RowOrder, ContinuesAfterClockWasSetBack) {
  for (const double back : {3600., 3000., 60., 2.5}) {
    auto times = ramp(8000);
    for (std::size_t i = 4000; i < times.size(); ++i) times[i] -= back;
    const auto rows = read_rows(make_table(times), map_with(OutOfOrder::shift), "f");
    ASSERT_TRUE(rows) << text(rows.error());
    ASSERT_EQ(rows->time.size(), 8000u) << "no row is lost";
    EXPECT_EQ(rows->time.back(), std::chrono::seconds(7999));
    EXPECT_EQ(rows->notes.front().rfind("the clock was set back 1 time, at first by ", 0), 0u) << rows->notes.front();
  }
}

TEST(RowOrder, LimitsShiftOfClockThatIsOftenSetBack) {
  constexpr double kYear_s = 365.25 * 86400;
  for (const double forward_s : {9.9 * kYear_s, 2 * kYear_s, 0.5 * kYear_s}) {
    std::vector<double> times;
    for (int i = 0; i < 60; ++i) times.insert(times.end(), {0., 1., forward_s});
    const auto rows = read_rows(make_table(times), map_with(OutOfOrder::shift), "f");
    ASSERT_FALSE(rows) << forward_s;
    EXPECT_EQ(rows.error().kind, FaultKind::bad_file);
    EXPECT_EQ(rows.error().where.rfind("f:", 0), 0u) << text(rows.error());
  }
  ImportMap dated = map_with(OutOfOrder::shift);
  dated.time_form = TimeForm::civil;
  std::string table = "t,T,w\n";
  for (int i = 0; i < 3; ++i) table += "2115-01-01T00:00:00Z,20,1\n2115-12-30T00:00:00Z,20,1\n";
  const auto rows = read_rows(table, dated, "f");
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().where, "f:4:1");
}

TEST(RowOrder, SuggestsRemedyFromLengthOfStep) {
  const auto said = [](const ImportMap& map, Duration back) { return out_of_order(map, back, {}).what; };
  ImportMap micros = rate_map(), civil = rate_map();
  micros.time_unit = std::chrono::microseconds(1);
  civil.time_form = TimeForm::date;
  EXPECT_NE(said(micros, std::chrono::microseconds(4294900000)).find("wrap = 4294967296"), std::string::npos);
  EXPECT_NE(said(micros, std::chrono::microseconds(65500)).find("wrap = 65536"), std::string::npos);
  EXPECT_NE(said(rate_map(), std::chrono::milliseconds(4294960000)).find("wrap = 4294967296"), std::string::npos);
  EXPECT_NE(said(civil, std::chrono::minutes(59)).find("put back for winter"), std::string::npos);
  EXPECT_NE(said(rate_map(), std::chrono::minutes(50)).find("logger's clock restarted"), std::string::npos);
  EXPECT_EQ(said(rate_map(), kSecond),
            "the time goes back 1 s, expected one after the row before, or out_of_order = \"skip\" in [time]");
}

TEST(RowOrder, ContinuesWhenCounterWraps) {
  for (const double wrap : {65536., 16777216., 4294967296.}) {
    ImportMap map = map_with(OutOfOrder::refuse);
    map.time_unit = std::chrono::microseconds(1);
    map.wrap = counted_time(wrap, map.time_unit);
    std::vector<double> times;
    for (int i = 0; i < 500; ++i) times.push_back(std::fmod(wrap - 50'000 + 1000. * i, wrap));
    const auto rows = read_rows(make_table(times), map, "f");
    ASSERT_TRUE(rows) << text(rows.error());
    EXPECT_EQ(rows->time.back(), std::chrono::milliseconds(499));
  }
}

}  // namespace
}  // namespace gyrotherm::exchange
