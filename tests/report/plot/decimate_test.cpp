// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "report/plot/plot.hpp"

namespace gyrotherm::plot {
namespace {

Points wave(std::size_t length) {
  Points points;
  for (std::size_t k = 0; k < length; ++k) {
    points.x.push_back(static_cast<double>(k));
    points.y.push_back(std::sin(0.001 * static_cast<double>(k)));
  }
  return points;
}

TEST(Decimation, LeavesShortSeriesUnchanged) {
  const Points points = wave(100);
  EXPECT_EQ(decimate(points.x, points.y, 50).y, points.y);
}

TEST(Decimation, KeepsSpikes) {
  Points points = wave(100000);
  points.y[54321] = 9;
  points.y[54322] = -7;
  const Points thin = decimate(points.x, points.y, 600);
  EXPECT_LE(thin.x.size(), 2 * 601U);
  EXPECT_EQ(*std::ranges::max_element(thin.y), 9);
  EXPECT_EQ(*std::ranges::min_element(thin.y), -7);
}

TEST(Decimation, KeepsOrderOfTime) {
  const Points points = wave(50000);
  EXPECT_TRUE(std::ranges::is_sorted(decimate(points.x, points.y, 300).x));
}

TEST(Decimation, KeepsGapOnce) {
  Points points = wave(10000);
  for (std::size_t k = 4000; k < 5000; ++k) points.y[k] = std::numeric_limits<double>::quiet_NaN();
  const Points thin = decimate(points.x, points.y, 100);
  EXPECT_EQ(std::ranges::count_if(thin.y, [](double y) { return std::isnan(y); }), 1);
}

TEST(Gaps, HaveNanAtStartOfFirstMissingMean) {
  const std::vector<double> x = {0, 100, 200, 400, 500}, y = {1, 2, 3, 4, 5};
  const Points broken = break_at_gaps(x, y, 100);
  EXPECT_EQ(broken.x, (std::vector<double>{0, 100, 200, 300, 400, 500}));
  EXPECT_TRUE(std::isnan(broken.y[3]));
  EXPECT_EQ(broken.y[4], 4);
  EXPECT_EQ(break_at_gaps({0, 100, 249}, {1, 2, 3}, 100).x.size(), 3u) << "one late row is not a gap";
  EXPECT_TRUE(break_at_gaps({}, {}, 100).x.empty());
}

}  // namespace
}  // namespace gyrotherm::plot
