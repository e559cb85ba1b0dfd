// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/civil_time.hpp"

#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <utility>

namespace gyrotherm::exchange {
namespace {

using std::chrono::hours, std::chrono::milliseconds, std::chrono::minutes, std::chrono::seconds;

TEST(CivilTime, IsReadInEachOfItsForms) {
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

TEST(CivilTime, WhatIsNoneIsRefused) {
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

TEST(CivilTime, AZoneIsReadAlone) {
  EXPECT_EQ(parse_zone("Z"), Duration{});
  EXPECT_EQ(parse_zone("-03:30"), -minutes(210));
  for (const std::string zone : {"", "CET", "+", "+1", "+24:00", "01:00", "+01:00 "})
    EXPECT_FALSE(parse_zone(zone)) << zone;
}

TEST(ReferenceTime, IsReadAsOthersWriteIt) {
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

TEST(ReferenceTime, DaysBeforeTheReformOfTheCalendarAreJulian) {
  constexpr std::int64_t kDay = 86400, kReform = -12219292800;
  EXPECT_EQ(parse_reference_time("1582-10-04", EarlyDays::julian)->seconds, kReform - kDay) << "ten days were left out";
  EXPECT_EQ(parse_reference_time("1582-10-05", EarlyDays::gregorian)->seconds, kReform - 10 * kDay);
  // 1721423.5 and 1721425.5 days of Scaliger's count, which stands at 2440587.5 in 1970
  EXPECT_EQ(parse_reference_time("0001-01-01", EarlyDays::julian)->seconds, (1721423 - 2440587) * kDay);
  EXPECT_EQ(parse_reference_time("0001-01-01", EarlyDays::gregorian)->seconds, (1721425 - 2440587) * kDay);
  EXPECT_EQ(parse_reference_time("1-1-1", EarlyDays::julian)->seconds, (1721423 - 2440587) * kDay);
  EXPECT_TRUE(parse_reference_time("1500-02-29", EarlyDays::julian));
  EXPECT_FALSE(parse_reference_time("1500-02-29", EarlyDays::gregorian));
  EXPECT_FALSE(parse_reference_time("1501-02-29", EarlyDays::julian));
}

TEST(ReferenceTime, WhatIsNoneIsRefused) {
  for (const std::string text : {"", "epoch", "2026", "2026-03", "2026-0-1", "2026-13-1", "2026-2-30", "2026-03-01T",
                                 "2026-03-01 12", "2026-03-01 24:00", "2026-03-01 12:60", "2026-03-01 12:00:61",
                                 "2026-03-01 12:00:00 CET", "2026-03-01 12:00:00 +", "2026-03-01 12:00 +25:00",
                                 "2026-03-01 12:00:00 +1:0", "20260-03-01", "-2026-03-01", "2026-003-01"})
    EXPECT_FALSE(parse_reference_time(text, EarlyDays::julian)) << text;
}

constexpr std::int64_t kFirstOfMarch = 1772323200;  // 2026-03-01T00:00Z, by `date -u -d`

std::optional<std::int64_t> seconds_of(const char* text, DateOrder order) {
  const auto time = parse_local_time(text, order);
  return time ? std::optional(std::chrono::floor<std::chrono::seconds>(time->reading).count()) : std::nullopt;
}

TEST(LocalTime, ReadsWhatLocalesWrite) {
  constexpr std::int64_t kMorning = kFirstOfMarch + 8 * 3600 + 10;
  for (const char* text :
       {"01.03.2026 08:00:10", "1.3.2026 8:00:10", "01.03.26 08:00:10", "1/3/2026 8:00:10 AM", "01-03-2026 08:00:10",
        "1. März 2026 08:00:10", "01-Mar-2026 08:00:10", "1 mars 2026 08:00:10", "01/03/2026, 08:00:10",
        "01.03.2026 08.00.10", "Sun, 1 Mar 2026 08:00:10 GMT"})
    EXPECT_EQ(seconds_of(text, DateOrder::day_first), kMorning) << text;
  for (const char* text :
       {"03/01/2026 08:00:10", "3/1/26 8:00:10 a.m.", "Mar 1, 2026 8:00:10 AM", "Sun Mar  1 08:00:10 2026"})
    EXPECT_EQ(seconds_of(text, DateOrder::month_first), kMorning) << text;
  for (const char* text : {"2026/03/01 08:00:10", "2026.03.01 08:00:10", "2026. 03. 01. 08:00:10", "20260301T080010Z",
                           "20260301 080010", "20260301080010", "2026-03-01_08:00:10", "2026-Mar-01 08:00:10"})
    EXPECT_EQ(seconds_of(text, DateOrder::year_first), kMorning) << text;
}

TEST(LocalTime, KnowsHalvesOfTheDayFractionsAndZones) {
  EXPECT_EQ(seconds_of("3/1/2026 12:00:10 AM", DateOrder::month_first), kFirstOfMarch + 10);
  EXPECT_EQ(seconds_of("3/1/2026 12:00:10 PM", DateOrder::month_first), kFirstOfMarch + 43210);
  EXPECT_EQ(seconds_of("3/1/2026 11:59 pm", DateOrder::month_first), kFirstOfMarch + 86340);
  EXPECT_EQ(
      parse_local_time("01.03.2026 00:00:00,25", DateOrder::day_first)->reading - std::chrono::seconds(kFirstOfMarch),
      std::chrono::milliseconds(250));
  EXPECT_EQ(parse_local_time("2026/03/01 08:00 +01:00", DateOrder::year_first)->zone, std::chrono::hours(1));
  EXPECT_FALSE(parse_local_time("01.03.2026 08:00", DateOrder::day_first)->zone);
}

TEST(LocalTime, RefusesWhatIsNone) {
  for (const char* text :
       {"", "1", "12.5", "1.5.7", "13/13/2026 08:00", "31.02.2026", "3/1/2026 13:00 PM", "3/1/2026 0:10 AM",
        "01.03.2026 25:00", "01.03.2026 08:61", "20261301", "1.000.000", "192.168.0.1", "01.03", "x1.3.2026"})
    for (const auto order : {DateOrder::day_first, DateOrder::month_first, DateOrder::year_first})
      EXPECT_FALSE(parse_local_time(text, order)) << text;
}

TEST(LocalTime, ReadsTimesOfDay) {
  for (const auto& [text, after_midnight_s] :
       {std::pair("08:00:10", 28810), std::pair("8:00", 28800), std::pair("8:00:10 PM", 72010),
        std::pair("080010", 28810), std::pair("08h00", 28800), std::pair("12:30 am", 1800)})
    EXPECT_EQ(parse_clock(text), std::chrono::seconds(after_midnight_s)) << text;
  for (const char* text : {"", "8", "8:0", "25:00", "13:00 PM", "08:00:61", "8.5"})
    EXPECT_FALSE(parse_clock(text)) << text;
}

TEST(LocalTime, KnowsWhatPeopleTakeForATime) {
  for (const char* text : {"2026-060 08:00:00", "1.3.26 8h", "08:00:00 CET", "12 Mar 26"})
    EXPECT_TRUE(looks_like_time(text)) << text;
  for (const char* text : {"", "ok", "-1.5", "1.5e-3", "marble", "A-B"}) EXPECT_FALSE(looks_like_time(text)) << text;
}

}  // namespace
}  // namespace gyrotherm::exchange
