// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/local_time.hpp"

#include <gtest/gtest.h>

#include <tuple>
#include <utility>

namespace gyrotherm::exchange {
namespace {

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
