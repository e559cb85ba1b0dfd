// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/table_columns.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <numeric>
#include <random>

namespace gyrotherm::report {
namespace {

double sum(const std::vector<double>& widths) { return std::accumulate(widths.begin(), widths.end(), 0.0); }

TEST(TableColumns, WhatIsLeftIsSharedInProportion) {
  EXPECT_EQ(column_widths({{10, 20}, {5, 30}}, 100), (std::vector<double>{40, 60}));
}

TEST(TableColumns, WhereNotAllFitTheWidestGiveWayAndShortOnesStayWhole) {
  const auto widths = column_widths({{20, 20}, {20, 120}}, 100);
  EXPECT_NEAR(widths[0], 20, 1e-9);
  EXPECT_NEAR(widths[1], 80, 1e-9);
}

TEST(TableColumns, WhereNotEvenTheLeastFitTheWidestAreNarrower) {
  const auto widths = column_widths({{10, 10}, {80, 90}, {90, 400}}, 100);
  EXPECT_NEAR(widths[0], 10, 1e-9);
  EXPECT_NEAR(widths[1], 45, 1e-9);
  EXPECT_NEAR(widths[2], 45, 1e-9);
}

TEST(TableColumns, TheyFillTheTableWhateverTheyWish) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> least(0, 60), more(0, 200);
    std::vector<ColumnWish> wishes(1 + engine() % 9);
    for (ColumnWish& wish : wishes) {
      wish.least = least(engine);
      wish.natural = wish.least + more(engine);
    }
    const auto widths = column_widths(wishes, 170);
    ASSERT_EQ(widths.size(), wishes.size());
    EXPECT_NEAR(sum(widths), 170, 1e-9);
    for (std::size_t k = 0; k < widths.size(); ++k)
      EXPECT_TRUE(!least_fit(wishes, 170) || widths[k] >= wishes[k].least - 1e-9);
  }
}

TEST(TableColumns, ColumnsOfNothingShareEvenly) {
  EXPECT_EQ(column_widths({{}, {}}, 100), (std::vector<double>{50, 50}));
}

}  // namespace
}  // namespace gyrotherm::report
