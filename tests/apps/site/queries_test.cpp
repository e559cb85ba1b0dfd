// SPDX-License-Identifier: Apache-2.0
#include "apps/site/queries.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace gyrotherm::site {
namespace {

/// A query that leaves out virtual runs also lists them with --all, and must then mark them.
TEST(Queries, MarkVirtualRunsThatTheyLeaveOutByDefault) {
  int checked = 0;
  for (const StoreQuery& query : queries()) {
    if (std::string_view(query.condition).find("simulated") == std::string_view::npos) continue;
    EXPECT_NE((", " + std::string(query.columns) + ",").find(", simulated,"), std::string::npos) << query.name;
    ++checked;
  }
  EXPECT_EQ(checked, 13);
}

/// The hours of the same runs have the same digits in each query.
TEST(Queries, RoundHoursToTheSameDigits) {
  int checked = 0;
  for (const StoreQuery& query : queries()) {
    const std::string columns = std::string(", ") + query.columns + ",";
    if (columns.find("hours") == std::string::npos) continue;
    EXPECT_NE(columns.find(", round(hours, 2) AS hours,"), std::string::npos) << query.name;
    ++checked;
  }
  EXPECT_EQ(checked, 2);
}

}  // namespace
}  // namespace gyrotherm::site
