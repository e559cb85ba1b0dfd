// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/foreign_time.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <utility>

#include "acquisition/record/csv.hpp"

namespace gyrotherm::exchange {
namespace {

using std::chrono::hours, std::chrono::microseconds, std::chrono::milliseconds, std::chrono::minutes,
    std::chrono::seconds;

constexpr Duration kNanosecond(1);

TEST(LocalTime, RefusesMonthsAndDaysOutsideCalendar) {
  std::size_t count = 0;
  for (const int wrong : {0, 32, 99, 256, 257, 260, 268, 513, 65537, 2147483647})
    for (const auto& text : {fmt::format("2026/{}/05 08:00", wrong), fmt::format("2026/03/{} 08:00", wrong),
                             fmt::format("2026-Mar-{} 08:00", wrong), fmt::format("Sun Mar {} 08:00:10 2026", wrong),
                             fmt::format("{}.03.2026 08:00", wrong), fmt::format("03/{}/2026 08:00", wrong),
                             fmt::format("Mar {}, 2026 08:00", wrong), fmt::format("2026-03-{:02} 08:00", wrong)})
      for (const auto order : {DateOrder::year_first, DateOrder::day_first, DateOrder::month_first}) {
        EXPECT_FALSE(parse_local_time(text, order)) << text;
        ++count;
      }
  EXPECT_EQ(count, 240u);
  EXPECT_TRUE(parse_local_time("2026/12/31 08:00", DateOrder::year_first));
  EXPECT_TRUE(parse_local_time("2026-Mar-31 08:00", DateOrder::year_first));
}

TEST(CountedTime, KeepsEveryNanosecondOfDecimalNumber) {
  struct Case {
    const char* text;
    Duration unit;
    std::int64_t seconds, part_ns;
  };
  for (const Case& one : {
           Case{"0", kSecond, 0, 0},
           Case{"1767225600.010001", kSecond, 1767225600, 10'001'000},
           Case{"1767225600.000000001", kSecond, 1767225600, 1},
           Case{"1767225600000000001", kNanosecond, 1767225600, 1},
           Case{"1767225600123.4567", milliseconds(1), 1767225600, 123'456'700},
           Case{"1767225600123456.7", microseconds(1), 1767225600, 123'456'700},
           Case{"0.29", kSecond, 0, 290'000'000},
           Case{"-0.25", kSecond, -1, 750'000'000},
           Case{"-1500", milliseconds(1), -2, 500'000'000},
           Case{"+.5", kSecond, 0, 500'000'000},
           Case{"7.", kSecond, 7, 0},
           Case{"0.0000000016", kSecond, 0, 2},
           Case{"20454.5", hours(24), 20454LL * 86400 + 43200, 0},
           Case{"1.5e3", milliseconds(1), 1, 500'000'000},
           Case{"1.7672256e+18", kNanosecond, 1767225600, 0},
           Case{"1767225600.0100010000000000000000", kSecond, 1767225600, 10'001'000},
       }) {
    const auto counted = parse_counted_time(one.text, one.unit);
    ASSERT_TRUE(counted) << one.text;
    EXPECT_EQ(counted->seconds, one.seconds) << one.text;
    EXPECT_EQ(counted->part.count(), one.part_ns) << one.text;
  }
}

TEST(CountedTime, EqualsAnyNumber) {
  constexpr unsigned kSeed = 20;
  std::mt19937_64 generator(kSeed);
  for (int i = 0; i < 20'000; ++i) {
    const auto ns = static_cast<std::int64_t>(generator() >> (1 + generator() % 60)) * (i % 2 == 0 ? 1 : -1);
    const auto text =
        fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", std::abs(ns) / 1'000'000'000, std::abs(ns) % 1'000'000'000);
    const auto as_seconds = parse_counted_time(text, kSecond),
               as_ns = parse_counted_time(std::to_string(ns), kNanosecond);
    ASSERT_TRUE(as_seconds && as_ns) << text << ", seed " << kSeed;
    EXPECT_EQ(as_seconds->seconds * 1'000'000'000 + as_seconds->part.count(), ns) << text << ", seed " << kSeed;
    EXPECT_EQ(duration_between(*as_seconds, *as_ns), Duration{}) << text << ", seed " << kSeed;
  }
}

TEST(CountedTime, AcceptsSameTextsAsOtherNumbers) {
  for (const std::string text : {"",     ".",    "-",     "+",      "+-5",
                                 "-+5",  "--5",  "5x",    "1 2",    "0x10",
                                 "nan",  "inf",  "1e999", "1,5",    "5..1",
                                 "5.-1", "5.+1", "5e",    "1_000",  "00012",
                                 "1e2",  "-5",   "-.5",   "5.5e-3", "99999999999999999999"})
    EXPECT_EQ(parse_counted_time(text, kSecond).has_value(), record::number_in(text).has_value()) << text;
}

TEST(CountedTime, RefusesTimesOutsideRangeOfRecord) {
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const CountedTime start = counted_time(std::int64_t{0}, kSecond);
  for (const Duration unit : {kNanosecond, Duration(milliseconds(1)), kSecond, Duration(hours(24))})
    for (const CountedTime& far : {counted_time(kMost, unit), counted_time(-kMost, unit), counted_time(1e300, unit),
                                   counted_time(-1e300, unit)}) {
      EXPECT_FALSE(duration_between(start, far));
      EXPECT_FALSE(duration_between(far, start));
      EXPECT_FALSE(to_utc(far + far));
    }
  EXPECT_EQ(duration_between(start, counted_time(std::int64_t{3652}, hours(24))), kLongestForeignTime);
  EXPECT_FALSE(to_utc(counted_time(std::int64_t{-1}, kNanosecond)));
  EXPECT_EQ(to_utc(counted_time(std::int64_t{1767225600}, kSecond)), kSecond * 1767225600);
}

TEST(CivilTime, ParsesEachForm) {
  constexpr Duration kNoon = seconds(1772366400);  // 2026-03-01T12:00:00, by `date -u -d`
  struct Case {
    const char* text;
    Duration reading;
    std::optional<Duration> zone;
  };
  for (const Case& one : {
           Case{"2026-03-01T12:00:00Z", kNoon, Duration{}},
           Case{"2026-03-01 12:00:00", kNoon, {}},
           Case{"2026-03-01T12:00", kNoon, {}},
           Case{"2026-03-01", kNoon - hours(12), {}},
           Case{"2026-03-01T12:00:00.25+01:00", kNoon + milliseconds(250), hours(1)},
           Case{"2026-03-01T12:00:00,123456789999 -0330", kNoon + Duration(123456789), -minutes(210)},
           Case{"2026-03-01T12:00+05", kNoon, hours(5)},
           Case{"2026-03-01T24:00:00Z", kNoon + hours(12), Duration{}},
           Case{"2024-02-29T00:00:00Z", seconds(1709164800), Duration{}},
           Case{"1970-01-01T00:00:00Z", Duration{}, Duration{}},
       }) {
    const auto time = parse_civil_time(one.text);
    ASSERT_TRUE(time) << one.text;
    EXPECT_EQ(time->reading, one.reading) << one.text;
    EXPECT_EQ(time->zone, one.zone) << one.text;
  }
}

TEST(CivilTime, RefusesOtherTexts) {
  for (const std::string text : {"",
                                 "2026",
                                 "2026-3-1",
                                 "2026-02-29",
                                 "2026-13-01",
                                 "2026-03-01T",
                                 "2026-03-01T12",
                                 "2026-03-01T12:60",
                                 "2026-03-01T25:00",
                                 "2026-03-01T24:30",
                                 "2026-03-01T24:30:00Z",
                                 "2026-03-01T24:00:01Z",
                                 "2026-03-01T24:00:00.5Z",
                                 "2026-03-01T12:00:61",
                                 "2026-03-01T12:00:00z9",
                                 "2026-03-01T12:00:00+1",
                                 "2026-03-01T12:00:00+01:0",
                                 "2026-03-01T12:00:00 CET",
                                 "01.03.2026 12:00",
                                 "+026-03-01",
                                 "2026-03-+1",
                                 "1969-12-31T23:59:59Z",
                                 "1970-01-01T00:00:00+01:00",
                                 "2117-01-01T00:00:00Z",
                                 "2026-03-01T12:00:00Z x"})
    EXPECT_FALSE(parse_civil_time(text)) << text;
}

TEST(CivilTime, ParsesZoneAlone) {
  EXPECT_EQ(parse_zone("Z"), Duration{});
  EXPECT_EQ(parse_zone("-03:30"), -minutes(210));
  for (const std::string zone : {"", "CET", "+", "+1", "+24:00", "01:00", "+01:00 "})
    EXPECT_FALSE(parse_zone(zone)) << zone;
}

TEST(ReferenceTime, ParsesNotationsOfOtherPrograms) {
  struct Case {
    const char* text;
    std::int64_t seconds;  ///< since 1970, by `date -u -d`
  };
  for (const Case& one : {
           Case{"2026-03-01 12:00:00", 1772366400},
           Case{"2026-03-01T12:00:00Z", 1772366400},
           Case{"2026-3-1 12:0:0", 1772366400},
           Case{"2026-03-01 12:00", 1772366400},
           Case{"2026-03-01 12:00:00.0 UTC", 1772366400},
           Case{"2026-03-01 12:00:00 GMT", 1772366400},
           Case{"2026-03-01 06:00:00 -6:00", 1772366400},
           Case{"2026-03-01 06:00:00 -6", 1772366400},
           Case{"2026-03-01T06:00:00-0600", 1772366400},
           Case{"2026-03-01 15:30:00 +330", 1772366400},
           Case{"2026-03-01", 1772323200},
           Case{"2026-03-01 UTC", 1772323200},
           Case{"1900-01-01 00:00:00.0", -2208988800},
           Case{"1582-10-15", -12219292800},
       })
    for (const auto early : {EarlyDays::julian, EarlyDays::gregorian}) {
      const auto time = parse_reference_time(one.text, early);
      ASSERT_TRUE(time) << one.text;
      EXPECT_EQ(time->seconds, one.seconds) << one.text;
      EXPECT_EQ(time->part, Duration{}) << one.text;
    }
  EXPECT_EQ(parse_reference_time("2026-03-01 12:00:00.25", EarlyDays::julian)->part, milliseconds(250));
}

TEST(ReferenceTime, UsesJulianCalendarBeforeReform) {
  constexpr std::int64_t kDay = 86400, kReform = -12219292800;
  EXPECT_EQ(parse_reference_time("1582-10-04", EarlyDays::julian)->seconds, kReform - kDay) << "ten days were omitted";
  EXPECT_EQ(parse_reference_time("1582-10-05", EarlyDays::gregorian)->seconds, kReform - 10 * kDay);
  // Julian day 1721423.5 and 1721425.5; 1970-01-01 is 2440587.5.
  EXPECT_EQ(parse_reference_time("0001-01-01", EarlyDays::julian)->seconds, (1721423 - 2440587) * kDay);
  EXPECT_EQ(parse_reference_time("0001-01-01", EarlyDays::gregorian)->seconds, (1721425 - 2440587) * kDay);
  EXPECT_EQ(parse_reference_time("1-1-1", EarlyDays::julian)->seconds, (1721423 - 2440587) * kDay);
  EXPECT_TRUE(parse_reference_time("1500-02-29", EarlyDays::julian));
  EXPECT_FALSE(parse_reference_time("1500-02-29", EarlyDays::gregorian));
  EXPECT_FALSE(parse_reference_time("1501-02-29", EarlyDays::julian));
}

TEST(ReferenceTime, RefusesOtherTexts) {
  for (const std::string text : {"", "epoch", "2026", "2026-03", "2026-0-1", "2026-13-1", "2026-2-30", "2026-03-01T",
                                 "2026-03-01 12", "2026-03-01 24:00", "2026-03-01 12:60", "2026-03-01 12:00:61",
                                 "2026-03-01 12:00:00 CET", "2026-03-01 12:00:00 +", "2026-03-01 12:00 +25:00",
                                 "2026-03-01 12:00:00 +1:0", "20260-03-01", "-2026-03-01", "2026-003-01"})
    EXPECT_FALSE(parse_reference_time(text, EarlyDays::julian)) << text;
}

constexpr std::int64_t kFirstOfMarch = 1772323200;  // 2026-03-01T00:00Z, by `date -u -d`

std::optional<std::int64_t> seconds_in(const char* text, DateOrder order) {
  const auto time = parse_local_time(text, order);
  return time ? std::optional(std::chrono::floor<std::chrono::seconds>(time->reading).count()) : std::nullopt;
}

TEST(LocalTime, ParsesLocalNotations) {
  constexpr std::int64_t kMorning = kFirstOfMarch + 8 * 3600 + 10;
  for (const char* text :
       {"01.03.2026 08:00:10", "1.3.2026 8:00:10", "01.03.26 08:00:10", "1/3/2026 8:00:10 AM", "01-03-2026 08:00:10",
        "1. März 2026 08:00:10", "01-Mar-2026 08:00:10", "1 mars 2026 08:00:10", "01/03/2026, 08:00:10",
        "01.03.2026 08.00.10", "Sun, 1 Mar 2026 08:00:10 GMT"})
    EXPECT_EQ(seconds_in(text, DateOrder::day_first), kMorning) << text;
  for (const char* text :
       {"03/01/2026 08:00:10", "3/1/26 8:00:10 a.m.", "Mar 1, 2026 8:00:10 AM", "Sun Mar  1 08:00:10 2026"})
    EXPECT_EQ(seconds_in(text, DateOrder::month_first), kMorning) << text;
  for (const char* text : {"2026/03/01 08:00:10", "2026.03.01 08:00:10", "2026. 03. 01. 08:00:10", "20260301T080010Z",
                           "20260301 080010", "20260301080010", "2026-03-01_08:00:10", "2026-Mar-01 08:00:10"})
    EXPECT_EQ(seconds_in(text, DateOrder::year_first), kMorning) << text;
}

TEST(LocalTime, ParsesHalfDaysFractionsAndZones) {
  EXPECT_EQ(seconds_in("3/1/2026 12:00:10 AM", DateOrder::month_first), kFirstOfMarch + 10);
  EXPECT_EQ(seconds_in("3/1/2026 12:00:10 PM", DateOrder::month_first), kFirstOfMarch + 43210);
  EXPECT_EQ(seconds_in("3/1/2026 11:59 pm", DateOrder::month_first), kFirstOfMarch + 86340);
  EXPECT_EQ(
      parse_local_time("01.03.2026 00:00:00,25", DateOrder::day_first)->reading - std::chrono::seconds(kFirstOfMarch),
      std::chrono::milliseconds(250));
  EXPECT_EQ(parse_local_time("2026/03/01 08:00 +01:00", DateOrder::year_first)->zone, std::chrono::hours(1));
  EXPECT_FALSE(parse_local_time("01.03.2026 08:00", DateOrder::day_first)->zone);
}

TEST(LocalTime, RefusesOtherTexts) {
  for (const char* text :
       {"", "1", "12.5", "1.5.7", "13/13/2026 08:00", "31.02.2026", "3/1/2026 13:00 PM", "3/1/2026 0:10 AM",
        "01.03.2026 25:00", "01.03.2026 08:61", "20261301", "1.000.000", "192.168.0.1", "01.03", "x1.3.2026"})
    for (const auto order : {DateOrder::day_first, DateOrder::month_first, DateOrder::year_first})
      EXPECT_FALSE(parse_local_time(text, order)) << text;
}

TEST(LocalTime, ParsesTimesOfDay) {
  for (const auto& [text, after_midnight_s] :
       {std::pair("08:00:10", 28810), std::pair("8:00", 28800), std::pair("8:00:10 PM", 72010),
        std::pair("080010", 28810), std::pair("08h00", 28800), std::pair("12:30 am", 1800)})
    EXPECT_EQ(parse_clock(text), std::chrono::seconds(after_midnight_s)) << text;
  for (const char* text : {"", "8", "8:0", "25:00", "13:00 PM", "08:00:61", "8.5"})
    EXPECT_FALSE(parse_clock(text)) << text;
}

TEST(LocalTime, DetectsTextsThatLookLikeTimes) {
  for (const char* text : {"2026-060 08:00:00", "1.3.26 8h", "08:00:00 CET", "12 Mar 26"})
    EXPECT_TRUE(looks_like_time(text)) << text;
  for (const char* text : {"", "ok", "-1.5", "1.5e-3", "marble", "A-B"}) EXPECT_FALSE(looks_like_time(text)) << text;
}

}  // namespace
}  // namespace gyrotherm::exchange
