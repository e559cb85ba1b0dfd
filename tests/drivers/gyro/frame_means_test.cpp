// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/frame_means.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/drivers/gyro/virtual_gyro_frame.hpp"
#include "tests/support/frame_streams.hpp"

namespace gyrotherm::drivers {
namespace {

/// A format of two values, and what their means, the frames and the flagged frames are.
FrameMeans means_over(const std::vector<GyroFrame>& frames) {
  static const auto format = frame_format_of(
      "[frame]\nname = \"f\"\nsync = [1]\nlength = 8\n[[frame.field]]\nrole = \"increment\"\ntype = \"u8\"\noffset = "
      "1\n"
      "[[frame.field]]\nrole = \"temperature\"\ntype = \"i8\"\noffset = 2\n"
      "[[frame.field]]\nname = \"current\"\nunit = \"mA\"\nrole = \"value\"\ntype = \"i8\"\noffset = 3\n");
  FrameMeans means(format);
  for (const auto& frame : frames) means.add(frame);
  return means;
}

TEST(FrameMeans, EachValueIsAveragedOverTheFramesThatHaveIt) {
  const auto means = means_over({{.values = {20, 1}}, {.values = {22, {}}}, {.values = {{}, 4}}, {.values = {{}, {}}}});
  EXPECT_EQ(means.values(), (std::vector<double>{21, 2.5, 3, 0})) << "the last frame carried nothing";
}

TEST(FrameMeans, WhatNoFrameHadIsNoNumber) {
  const auto values = means_over({{.values = {20, {}}}}).values();
  EXPECT_EQ(values[0], 20);
  EXPECT_TRUE(std::isnan(values[1]));
  EXPECT_EQ(values[2], 1);
  const auto none = means_over({}).values();
  EXPECT_TRUE(std::isnan(none[0]) && std::isnan(none[1]));
  EXPECT_EQ(none[2], 0);
}

TEST(FrameMeans, AnInvalidFrameIsCountedAsFlaggedButNotAveraged) {
  const auto means = means_over({{.values = {20, 1}},
                                 {.good = false, .flagged = true, .values = {99, 99}},
                                 {.flagged = true, .values = {22, 3}},
                                 {.flagged = true, .values = {{}, {}}}});
  EXPECT_EQ(means.values(), (std::vector<double>{21, 2, 2, 3}));
}

TEST(FrameMeans, BeginsWithNothing) {
  auto means = means_over({{.flagged = true, .values = {20, 1}}});
  means.begin();
  means.add({.values = {10, 2}});
  EXPECT_EQ(means.values(), (std::vector<double>{10, 2, 1, 0}));
}

TEST(FrameMeans, AFormatWithoutHousekeepingHasNone) {
  FrameMeans means(virtual_gyro_frame());
  means.add({.axes = {{.pulses = 1}}, .flagged = true});
  EXPECT_TRUE(means.values().empty());
}

/// A day of seconds of a thousand frames, each the sum of its own numbers alone.
TEST(FrameMeans, KeepNoTraceOfTheSecondBefore) {
  auto means = means_over({});
  for (int second = 0; second < 100; ++second) {
    means.begin();
    for (int i = 0; i < 1000; ++i) means.add({.values = {second + 0.001 * (i - 499.5), 1e6}});
    EXPECT_NEAR(means.values()[0], second, 1e-9);
    EXPECT_EQ(means.values()[1], 1e6);
    EXPECT_EQ(means.values()[2], 1000);
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
