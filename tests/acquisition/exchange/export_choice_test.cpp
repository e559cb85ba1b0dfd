// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/export_choice.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace gyrotherm::exchange {
namespace {

using std::chrono::milliseconds;

/// Returns an imported record without channels.
record::Record rows_every(Duration spacing, int rows) {
  record::Record record;
  record.info.imported = true;
  for (int row = 0; row < rows; ++row) {
    record.slot.push_back(row);
    record.time_s.push_back(to_seconds(spacing * row));
    record.set_point_c.push_back(row);
  }
  return record;
}

TEST(ExportChoice, AssignsRowsToStretchesBelowOneSecond) {
  struct Case {
    milliseconds spacing, every;
    std::size_t stretches;
  };
  for (const Case& one : {Case{milliseconds(10), milliseconds(10), 1000}, Case{milliseconds(10), milliseconds(70), 143},
                          Case{milliseconds(1), milliseconds(100), 10}, Case{milliseconds(3), milliseconds(3), 1000}}) {
    const auto chosen = chosen_rows(rows_every(one.spacing, 1000), {.every = one.every});
    EXPECT_EQ(chosen.slot.size(), one.stretches) << one.every.count() << " ms";
    for (std::size_t i = 0; i < std::min(one.stretches, chosen.slot.size()); ++i) {
      const auto begins = one.every * static_cast<int>(i);
      const auto first = (begins + one.spacing - milliseconds(1)) / one.spacing;
      EXPECT_EQ(chosen.slot[i], first) << one.every.count() << " ms";
    }
  }
}

}  // namespace
}  // namespace gyrotherm::exchange
