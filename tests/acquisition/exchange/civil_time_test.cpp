// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/civil_time.hpp"

#include <gtest/gtest.h>

#include <string>

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

}  // namespace
}  // namespace gyrotherm::exchange
