// SPDX-License-Identifier: Apache-2.0
#include "report/lot.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace gyrotherm::report {
namespace {

Lot make_lot(std::size_t axes) {
  Lot lot;
  lot.rig_title = "bench";
  for (std::size_t i = 0; i < axes; ++i) {
    LotAxis axis;
    axis.unit = fmt::format("u{}", i + 1);
    axis.verdict = "pass";
    axis.raw_std_deg_per_h = 1 + 0.1 * static_cast<double>(i);
    axis.compensated_std_deg_per_h = 0.1 + 0.01 * static_cast<double>(i);
    lot.axes.push_back(axis);
  }
  compare(lot);
  return lot;
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(Lot, StatesUnitAndMeaningOfTerminalTable) {
  const auto text = describe(make_lot(7));
  EXPECT_TRUE(contains(text, "STD of the bias in the random run, °/h")) << text;
  EXPECT_FALSE(contains(text, "no score")) << text;
  EXPECT_TRUE(contains(to_html(make_lot(7)), "The score is 0.6745 times the distance"));
}

TEST(Lot, StatesWhyThereIsNoScore) {
  for (const std::size_t axes : {1U, 5U}) {
    EXPECT_TRUE(contains(describe(make_lot(axes)), "no score: at least 6 axes are needed\n")) << axes;
    EXPECT_TRUE(contains(to_html(make_lot(axes)), "no score: at least 6 axes are needed.")) << axes;
  }
  auto equal = make_lot(6);
  for (auto& axis : equal.axes) axis.raw_std_deg_per_h = axis.compensated_std_deg_per_h = 1;
  compare(equal);
  EXPECT_TRUE(contains(describe(equal), "half of the results are equal")) << describe(equal);
}

}  // namespace
}  // namespace gyrotherm::report
