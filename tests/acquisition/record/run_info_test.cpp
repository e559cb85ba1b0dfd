// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/run_info.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"

namespace gyrotherm::record {
namespace {

using std::chrono::days;

Channel channel_a() { return {.name = "A", .instrument = "a bridge", .offset = {}}; }

TEST(Calibration, AddsOffset) {
  auto channel = channel_a();
  channel.offset = {0.25};
  EXPECT_EQ(calibrated(channel, {-40}), Celsius{-39.75});
}

TEST(Calibration, AppliesPolynomialInsteadOfOffset) {
  auto channel = channel_a();
  channel.polynomial = {0.5, 1.01, -1e-3};
  EXPECT_DOUBLE_EQ(calibrated(channel, {20}).value, 0.5 + 1.01 * 20 - 1e-3 * 400);
  channel.polynomial = {0, 1};
  for (int i = -400; i < 600; ++i) EXPECT_EQ(calibrated(channel, {0.1 * i}), Celsius{0.1 * i});
}

TEST(Calibration, ParsesDayOfFourTwoAndTwoDigits) {
  for (const char* text : {"2028-02-29", "1678-01-01", "2261-12-31"})
    EXPECT_EQ(format_day(parse_day(text).value()), text);
  for (const char* text :
       {"", "2027-02-29", "2027-13-01", "2027-00-10", "2027-1-1", "27-01-01", "2027-01-0x", "+027-01-01", "2027-01-01T",
        "2027/01/01", "2027-01--1", "1677-12-31", "2262-01-01", "2999-12-31", "9999-12-31"})
    EXPECT_FALSE(parse_day(text)) << text;
}

TEST(Calibration, IsValidThroughLastDay) {
  auto channel = channel_a();
  channel.certificate = "2025-0815";
  channel.due = parse_day("2025-12-31");
  const std::vector<Channel> channels{channel_a(), channel};
  EXPECT_TRUE(overdue_calibrations(channels, kVirtualEpoch - std::chrono::seconds(1)).empty());
  const auto lines = overdue_calibrations(channels, kVirtualEpoch);  // 2026-01-01
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0], "calibration of A (certificate 2025-0815) was due 2025-12-31");
}

TEST(Calibration, DescribesItself) {
  auto channel = channel_a();
  EXPECT_EQ(describe_calibration(channel), "none");
  channel.offset = {-0.012};
  EXPECT_EQ(describe_calibration(channel), "offset -0.012 K");
  channel.polynomial = {0.5, 1};
  channel.offset = {};
  channel.certificate = "C1";
  channel.due = parse_day("2027-03-01");
  EXPECT_EQ(describe_calibration(channel), "polynomial 0.5, 1, certificate C1, due 2027-03-01");
}

}  // namespace
}  // namespace gyrotherm::record
