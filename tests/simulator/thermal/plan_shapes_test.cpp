// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simulator/thermal/gyro_parts.hpp"

namespace gyrotherm::thermal {
namespace {

TEST(PlanShapes, HaveAreaOfCircle) { EXPECT_NEAR(area(circle({3, -2}, 30)), std::numbers::pi * 900, 1e-9); }

TEST(PlanShapes, IntersectSquaresToOctagon) {
  const double half = 1;
  const double diagonal = half * std::numbers::sqrt2;
  const Outline turned{{0, -diagonal}, {diagonal, 0}, {0, diagonal}, {-diagonal, 0}};
  EXPECT_NEAR(area(intersection(to_outline({-half, half, -half, half}), turned)), 8 * (std::numbers::sqrt2 - 1), 1e-12);
}

TEST(PlanShapes, HaveEmptyIntersectionWhenApart) {
  EXPECT_EQ(area(intersection(to_outline({0, 1, 0, 1}), to_outline({2, 3, 0, 1}))), 0);
  EXPECT_EQ(area(intersection(to_outline({0, 1, 0, 1}), to_outline({1, 2, 0, 1}))), 0);
}

/// A shape that is cut into rectangles at random lines keeps its area.
TEST(PlanShapes, KeepTotalAreaWhenCut) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> place(-12, 12);
    std::vector<double> x{-20, place(engine), place(engine), place(engine), 20};
    std::vector<double> y{-20, place(engine), place(engine), 20};
    std::ranges::sort(x);
    std::ranges::sort(y);
    const auto shape = circle({place(engine) / 4, place(engine) / 4}, 11);
    double sum = 0;
    for (std::size_t i = 1; i < x.size(); ++i)
      for (std::size_t j = 1; j < y.size(); ++j)
        sum += area(intersection(shape, to_outline({x[i - 1], x[i], y[j - 1], y[j]})));
    EXPECT_NEAR(sum, area(shape), 1e-9) << "seed " << seed;
  }
}

}  // namespace
}  // namespace gyrotherm::thermal
