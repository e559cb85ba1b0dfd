// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/row_pipe.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace gyrotherm::exchange {
namespace {

// Several batches and a partial one.
constexpr int kPipedRows = 20'001;

ImportedRow make_row(const std::vector<double>& numbers, int second) {
  return {.time = std::chrono::seconds(second), .usual = std::chrono::seconds(1), .numbers = numbers};
}

TEST(RowPipe, WritesRowsInOrderWithNumbers) {
  int written = 0;
  RowPipe pipe([&](const ImportedRow& row) -> Result<void> {
    EXPECT_EQ(row.time, std::chrono::seconds(written));
    EXPECT_EQ(std::vector<double>(row.numbers.begin(), row.numbers.end()), (std::vector<double>{1.0 * written, 0.5}));
    ++written;
    return {};
  });
  for (int i = 0; i < kPipedRows; ++i) ASSERT_TRUE(pipe.push(make_row({1.0 * i, 0.5}, i)));
  ASSERT_TRUE(pipe.finish());
  EXPECT_EQ(written, kPipedRows);
}

TEST(RowPipe, ReportsWriteFaultToReader) {
  constexpr int kLast = 5000;
  int written = 0;
  RowPipe pipe([&](const ImportedRow&) -> Result<void> {
    if (++written == kLast) return failure(FaultKind::storage, "run.db", "the disk is full");
    return {};
  });
  Result<void> pushed;
  for (int i = 0; pushed && i < 100 * kPipedRows; ++i) pushed = pipe.push(make_row({1}, i));
  ASSERT_FALSE(pushed);
  EXPECT_EQ(pushed.error().what, "the disk is full");
  EXPECT_EQ(pipe.finish().error().what, "the disk is full");
  EXPECT_EQ(written, kLast) << "no row is written after the fault";
}

TEST(RowPipe, FinishesImmediatelyWithoutRows) {
  RowPipe pipe([](const ImportedRow&) -> Result<void> { return {}; });
  EXPECT_TRUE(pipe.finish());
}

TEST(RowPipe, DropsWaitingRowsWhenDestroyed) {
  RowPipe pipe([](const ImportedRow&) -> Result<void> { return {}; });
  for (int i = 0; i < kPipedRows; ++i) ASSERT_TRUE(pipe.push(make_row({1}, i)));
}

}  // namespace
}  // namespace gyrotherm::exchange
