// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/counted_time.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/record/csv.hpp"

namespace gyrotherm::exchange {
namespace {

using std::chrono::hours, std::chrono::microseconds, std::chrono::milliseconds;

constexpr Duration kNanosecond(1);

TEST(CountedTime, KeepsEveryNanosecondOfADecimalNumber) {
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

TEST(CountedTime, OfAnyNumberIsWhatTheNumberSays) {
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
    EXPECT_EQ(between(*as_seconds, *as_ns), Duration{}) << text << ", seed " << kSeed;
  }
}

TEST(CountedTime, IsANumberWhereAnyOtherFieldIsOne) {
  for (const std::string text : {"",     ".",    "-",     "+",      "+-5",
                                 "-+5",  "--5",  "5x",    "1 2",    "0x10",
                                 "nan",  "inf",  "1e999", "1,5",    "5..1",
                                 "5.-1", "5.+1", "5e",    "1_000",  "00012",
                                 "1e2",  "-5",   "-.5",   "5.5e-3", "99999999999999999999"})
    EXPECT_EQ(parse_counted_time(text, kSecond).has_value(), record::number_in(text).has_value()) << text;
}

TEST(CountedTime, BeyondWhatARecordCanHaveIsToldAndNotComputedWith) {
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  const CountedTime start = counted_time(std::int64_t{0}, kSecond);
  for (const Duration unit : {kNanosecond, Duration(milliseconds(1)), kSecond, Duration(hours(24))})
    for (const CountedTime& far : {counted_time(kMost, unit), counted_time(-kMost, unit), counted_time(1e300, unit),
                                   counted_time(-1e300, unit)}) {
      EXPECT_FALSE(between(start, far));
      EXPECT_FALSE(between(far, start));
      EXPECT_FALSE(utc_of(far + far));
    }
  EXPECT_EQ(between(start, counted_time(std::int64_t{3652}, hours(24))), kLongestForeignTime);
  EXPECT_FALSE(utc_of(counted_time(std::int64_t{-1}, kNanosecond)));
  EXPECT_EQ(utc_of(counted_time(std::int64_t{1767225600}, kSecond)), kSecond * 1767225600);
}

}  // namespace
}  // namespace gyrotherm::exchange
