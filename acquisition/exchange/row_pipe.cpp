// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/row_pipe.hpp"

#include <utility>

#include "core/process.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kRowsOfBatch = 2048, kMaxWaiting = 4;

}  // namespace

RowPipe::RowPipe(TakeImported write) : write_(std::move(write)), worker_([this] { work(); }) {}

RowPipe::~RowPipe() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  if (worker_.joinable()) worker_.join();
}

Result<void> RowPipe::push(const ImportedRow& row) {
  filling_.numbers.insert(filling_.numbers.end(), row.numbers.begin(), row.numbers.end());
  filling_.rows.push_back(row);
  return filling_.rows.size() < kRowsOfBatch ? Result<void>() : hand_over();
}

Result<void> RowPipe::finish() {
  if (!worker_.joinable()) return {};
  auto passed = filling_.rows.empty() ? Result<void>() : hand_over();
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  worker_.join();
  return fault_ ? failure(*fault_) : passed;
}

Result<void> RowPipe::hand_over() {
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return waiting_.size() < kMaxWaiting || fault_; });
    if (fault_) return failure(*fault_);
    waiting_.push_back(std::move(filling_));
    filling_ = {};
    if (!empty_.empty()) {
      filling_ = std::move(empty_.front());
      empty_.pop_front();
    }
  }
  changed_.notify_all();
  return {};
}

Result<void> RowPipe::write_all(Batch& batch) {
  std::span<const double> numbers = batch.numbers;
  const std::size_t columns = batch.numbers.size() / batch.rows.size();
  for (ImportedRow& row : batch.rows) {
    row.numbers = numbers.first(columns);
    numbers = numbers.subspan(columns);
    if (auto written = write_(row); !written) return written;
  }
  return {};
}

void RowPipe::work() {
  block_signals();
  for (;;) {
    Batch batch;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return !waiting_.empty() || ended_; });
      if (waiting_.empty()) return;
      batch = std::move(waiting_.front());
      waiting_.pop_front();
    }
    changed_.notify_all();
    auto written = write_all(batch);
    batch.rows.clear();
    batch.numbers.clear();
    const std::lock_guard lock(mutex_);
    empty_.push_back(std::move(batch));
    if (written) continue;
    fault_ = std::move(written.error());
    changed_.notify_all();
    return;
  }
}

}  // namespace gyrotherm::exchange
