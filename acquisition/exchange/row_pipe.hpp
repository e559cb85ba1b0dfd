// SPDX-License-Identifier: Apache-2.0
/// Passes rows from the thread that reads a file to a thread that writes them. Both work at the same time. The queue
/// between them is bounded, and the faster thread waits for the slower one.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "acquisition/exchange/grouping.hpp"

namespace gyrotherm::exchange {

/// A bounded queue of rows with a writing thread.
class RowPipe {
 public:
  /// Starts the thread, which calls `write` with each row, in order.
  explicit RowPipe(TakeImported write);
  /// Drops the rows that have not been written.
  ~RowPipe();
  RowPipe(const RowPipe&) = delete;
  RowPipe& operator=(const RowPipe&) = delete;

  /// Copies a row into the queue. Fails with the fault of `write` for an earlier row.
  [[nodiscard]] Result<void> push(const ImportedRow& row);
  /// Waits until all rows are written. Fails as push() does.
  [[nodiscard]] Result<void> finish();

 private:
  struct Batch {
    /// Rows without their numbers, which are concatenated in `numbers`.
    std::vector<ImportedRow> rows{};
    std::vector<double> numbers{};
  };
  void work();
  [[nodiscard]] Result<void> write_all(Batch& batch);
  [[nodiscard]] Result<void> hand_over();

  TakeImported write_;
  Batch filling_{};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Batch> waiting_{}, empty_{};
  bool ended_ = false;
  std::optional<Fault> fault_{};
  std::thread worker_;
};

}  // namespace gyrotherm::exchange
