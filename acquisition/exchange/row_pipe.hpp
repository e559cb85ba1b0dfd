// SPDX-License-Identifier: Apache-2.0
/// Rows on their way from the thread that reads a foreign file to one that writes them, so that both go on at the same
/// time. What is on the way is bounded; whoever is faster waits.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "acquisition/exchange/grouping.hpp"

namespace gyrotherm::exchange {

class RowPipe {
 public:
  /// `write` is called with each row, in order, on the thread of this.
  explicit RowPipe(TakeImported write);
  /// Rows that are on the way are dropped.
  ~RowPipe();
  RowPipe(const RowPipe&) = delete;
  RowPipe& operator=(const RowPipe&) = delete;

  /// Copies the row. Fails as `write` has failed for a row before.
  [[nodiscard]] Result<void> push(const ImportedRow& row);
  /// Waits until all rows are written. Fails likewise.
  [[nodiscard]] Result<void> finish();

 private:
  struct Batch {
    std::vector<ImportedRow> rows{};  ///< without their numbers, which lie one behind the other
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
