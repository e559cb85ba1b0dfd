// SPDX-License-Identifier: Apache-2.0
#include "core/quantity.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace gyrotherm {
namespace {

template <class A, class B>
concept Addable = requires(A a, B b) {
  a + b;
};

static_assert(!Addable<Celsius, Celsius>, "temperatures cannot be added");
static_assert(Addable<Celsius, Kelvins>);
static_assert(std::is_same_v<decltype(Celsius{} - Celsius{}), Kelvins>);

TEST(Quantity, SubtractsPointsToDifference) {
  EXPECT_EQ(Celsius{60} - Celsius{-40}, Kelvins{100});
  EXPECT_EQ(Celsius{-40} + Kelvins{100}, Celsius{60});
  EXPECT_EQ(abs(Celsius{-40} - Celsius{60}), Kelvins{100});
}

TEST(Quantity, MultipliesRateByTime) {
  EXPECT_EQ(CelsiusPerMinute{5} * std::chrono::minutes(20), Kelvins{100});
  EXPECT_EQ(Kelvins{100} / CelsiusPerMinute{5}, std::chrono::minutes(20));
  EXPECT_EQ(Kelvins{100} / CelsiusPerMinute{3}, std::chrono::seconds(2000));
}

TEST(Quantity, ConvertsSecondsToNanosecondsAndBackExactly) {
  for (const double s : {0.0, 0.25, 1.0, 221600.0, 1e8}) EXPECT_EQ(to_seconds(from_seconds(s)), s);
  EXPECT_EQ(from_seconds(-1.5), std::chrono::milliseconds(-1500));
}

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

TEST(ParseQuantity, AcceptsNumberWithKnownUnit) {
  constexpr std::array<std::string_view, 2> kUnits{"°C", "K"};
  const std::vector<std::pair<std::string, double>> golden{
      {"-40 °C", -40}, {"60°C", 60}, {"+2.5 K", 2.5}, {"1e1 K", 10}, {"0 K", 0}};
  for (const auto& [text, expected] : golden) EXPECT_EQ(parse_quantity(text, kUnits), expected) << text;
  for (const std::string text : {"", " ", "5", "K", "5 °F", "5 k", "5 K x", "5 K 6 K", "+-5 K", "--5 K", "nan K",
                                 "inf K", "0x10 K", "1,5 K", "5 °"})
    EXPECT_EQ(parse_quantity(text, kUnits), std::nullopt) << text;
}

TEST(ParseDuration, AcceptsKnownTexts) {
  const std::vector<std::pair<std::string, Duration>> golden{
      {"2 h", hours(2)},           {"2h", hours(2)},         {"90 s", seconds(90)},
      {"1 h 30 min", minutes(90)}, {"1h30min", minutes(90)}, {"250 ms", milliseconds(250)},
      {"1.5 h", minutes(90)},      {" 1 d ", hours(24)},     {"0 s", seconds(0)},
      {"+5 s", seconds(5)},        {"1e3 s", seconds(1000)}, {"100000000 s", seconds(100'000'000)}};
  for (const auto& [text, expected] : golden) {
    const auto d = parse_duration(text);
    ASSERT_TRUE(d.has_value()) << text;
    EXPECT_EQ(*d, expected) << text;
  }
}

TEST(ParseDuration, QuotesInvalidText) {
  for (const std::string text : {"", " ", "5", "h", "5 hours", "-5 s", "+-5 s", "1 h -30 min", "nan s", "inf s",
                                 "1e9 s", "1e400 s", "5 s x", "5 m", "1 h . 5 min", "0x10 s"}) {
    const auto d = parse_duration(text);
    ASSERT_FALSE(d.has_value()) << text;
    EXPECT_EQ(d.error().kind, FaultKind::bad_file);
    EXPECT_NE(d.error().what.find("\"" + text + "\""), std::string::npos);
  }
}

TEST(ParseDuration, StatesLongestDuration) {
  EXPECT_TRUE(parse_duration("27777 h"));
  for (const std::string text : {"27778 h", "1000000 h", "1200 d"}) {
    const auto d = parse_duration(text);
    ASSERT_FALSE(d.has_value()) << text;
    EXPECT_EQ(d.error().what, "\"" + text + "\" is too long; expected at most 27777 h");
  }
}

}  // namespace
}  // namespace gyrotherm
