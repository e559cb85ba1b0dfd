// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/thermometer/pt12.hpp"

namespace gyrotherm::drivers {
namespace {

// Sample reply in the manual.
constexpr const char* kSample =
    "25.38095, 25.26928, 25.53783, 25.27834, 25.38860, 25.23795, NaN, 25.41134, 25.48914, NaN, 25.34643, 25.37140";

TEST(Pt12Codec, ReadsTheReplyOfTheManual) {
  const auto readings = decode_pt12_temperatures(kSample).value();
  ASSERT_EQ(readings.size(), kPt12Inputs);
  EXPECT_EQ(readings[0].value(), Celsius{25.38095});
  EXPECT_EQ(readings[11].value(), Celsius{25.37140});
  for (std::size_t i = 0; i < kPt12Inputs; ++i) EXPECT_EQ(readings[i].has_value(), i != 6 && i != 9) << i;
}

/// Returns the first of twelve readings, sent as `text`.
Result<Celsius> first_reading(const std::string& text) {
  const auto readings = decode_pt12_temperatures(text + ",2,3,4,5,6,7,8,9,10,11,12");
  return readings ? readings->front() : failure(readings.error());
}

TEST(Pt12Codec, ReportsFaultOfInputWithoutProbe) {
  const auto readings = decode_pt12_temperatures(kSample).value();
  EXPECT_EQ(readings[6].error().kind, FaultKind::out_of_range);
  EXPECT_EQ(text(readings[6].error()), "T7: no probe is connected (NaN)");
  for (const char* nan : {"NaN", "nan", "NAN"}) EXPECT_FALSE(first_reading(nan)) << nan;
}

TEST(Pt12Codec, NumbersAreStandardOrScientific) {
  for (const char* same : {"12.34", "1234e-2", "1.234e1", "1.234E+1", "+12.34", " 12.34 ", "12.340000", "012.34"})
    EXPECT_DOUBLE_EQ(first_reading(same).value().value, 12.34) << same;
  EXPECT_EQ(first_reading("-10.015").value(), Celsius{-10.015});
}

TEST(Pt12Codec, RejectsInvalidNumber) {
  for (const char* wrong : {"", " ", "-", "+", "+-1", "-+1", "--1", "1e", "1e400", "1 2", "1,2", "0x10", "inf", "-nan",
                            "nan(1)", "NaNs", "1.2.3", "1\t", "12.34C"})
    EXPECT_EQ(first_reading(wrong).error().kind, FaultKind::corrupted) << wrong;
  EXPECT_EQ(first_reading("x").error().where, "T?");
}

TEST(Pt12Codec, AnythingButTwelveNumbersIsCorrupted) {
  for (const char* wrong :
       {"", "1", "1,2,3,4,5,6,7,8,9,10,11", "1,2,3,4,5,6,7,8,9,10,11,12,13", "1,2,3,4,5,6,7,8,9,10,11,12,",
        "1,2,3,4,5,6,7,8,9,10,11,", "1,2,,4,5,6,7,8,9,10,11,12", "1;2;3;4;5;6;7;8;9;10;11;12", "PT12"})
    EXPECT_EQ(decode_pt12_temperatures(wrong).error().kind, FaultKind::corrupted) << wrong;
}

TEST(Pt12Codec, ReportsFaultOfReadingOutsidePlatinumRange) {
  for (const char* wrong : {"-200.001", "850.001", "1e300", "-1e300"})
    EXPECT_EQ(first_reading(wrong).error().kind, FaultKind::out_of_range) << wrong;
  EXPECT_TRUE(first_reading("-200"));
  EXPECT_TRUE(first_reading("850"));
}

TEST(Pt12Codec, WhatEncodesDecodesToTheSame) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 1000; ++round) {
    std::vector<std::optional<double>> celsius;
    for (std::size_t i = 0; i < kPt12Inputs; ++i)
      celsius.push_back(random() % 5 == 0 ? std::nullopt
                                          : std::optional(std::round(random() % 90'000'000) / 1e5 - 100));
    const auto readings = decode_pt12_temperatures(encode_pt12_temperatures(celsius)).value();
    for (std::size_t i = 0; i < kPt12Inputs; ++i) {
      ASSERT_EQ(readings[i].has_value(), celsius[i].has_value()) << "seed " << kSeed << " round " << round;
      if (!celsius[i]) continue;
      EXPECT_NEAR(readings[i]->value, *celsius[i], 5.1e-6) << "seed " << kSeed << " round " << round;
    }
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
