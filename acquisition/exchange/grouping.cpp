// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/grouping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "acquisition/exchange/row_order.hpp"
#include "acquisition/record/row.hpp"

namespace gyrotherm::exchange {

namespace {

/// Returns the number of latest stretches that still accept rows. A log may write its messages seconds after the
/// measurement, with a different delay for each topic. Rows of a table are late by at most one stretch.
std::size_t max_open_stretches(const ImportMap& map) {
  constexpr std::size_t kTableStretches = 2, kMaxStretches = 1000;
  constexpr Duration kMaxDelay = std::chrono::seconds(5);
  const bool is_log = map.format == FileFormat::ulog || map.format == FileFormat::dataflash;
  if (!is_log || map.every <= Duration{}) return kTableStretches;
  return std::clamp<std::size_t>(static_cast<std::size_t>(kMaxDelay / map.every) + 1, kTableStretches, kMaxStretches);
}

constexpr std::size_t kMaxRowsHeldBack = 1 << 16, kMaxNumbersHeldBack = 1 << 22;

}  // namespace

Result<void> Spacing::push(const ForeignRow& row) {
  if (last_ && (row.time < *last_ || (row.time == *last_ && map_.every == Duration{})))
    return failure(out_of_order(map_, *last_ - row.time, row.utc));
  if (!first_) first_ = row.time;
  const auto since_before = last_ ? std::optional(row.time - *last_) : std::nullopt;
  last_ = row.time;
  if (usual_ > Duration{}) return pass_on(row, since_before);
  hold_back(row);
  const bool is_enough = times_.size() == kMaxRowsHeldBack || numbers_.size() >= kMaxNumbersHeldBack;
  return is_enough && times_.size() > 1 ? finish() : Result<void>{};
}

void Spacing::hold_back(const ForeignRow& row) {
  times_.push_back(row.time);
  utcs_.push_back(row.utc);
  numbers_.insert(numbers_.end(), row.numbers.begin(), row.numbers.end());
}

Result<void> Spacing::pass_on(const ForeignRow& row, std::optional<Duration> since_before) {
  const bool since_row_before = map_.time && map_.counts_increments() && since_before;
  return take_({.time = row.time - *first_,
                .utc = row.utc,
                .interval = since_row_before ? *since_before : usual_,
                .usual = usual_,
                .numbers = row.numbers});
}

Result<void> Spacing::finish() {
  if (times_.empty()) return {};
  auto distinct = times_;
  const auto repeated = std::ranges::unique(distinct);
  distinct.erase(repeated.begin(), repeated.end());
  usual_ = std::max(usual_step(distinct), Duration(1));
  const std::size_t columns = numbers_.size() / times_.size();
  for (std::size_t i = 0; i < times_.size(); ++i) {
    const auto since_before = i > 0 ? std::optional(times_[i] - times_[i - 1]) : std::nullopt;
    const auto numbers = std::span<const double>(numbers_).subspan(i * columns, columns);
    if (auto passed = pass_on({times_[i], utcs_[i], numbers}, since_before); !passed) return passed;
  }
  times_ = {};
  utcs_ = {};
  numbers_ = {};
  return {};
}

Grouping::Grouping(const ImportMap& map, TakeImported take)
    : map_(map),
      take_(std::move(take)),
      columns_(map.columns().size()),
      increments_(map),
      most_open_(max_open_stretches(map)) {}

Grouping::Stretch& Grouping::stretch_at(const std::deque<Stretch>::iterator& position, std::int64_t number) {
  if (position != open_.end() && position->number == number) return *position;
  return *open_.insert(
      position,
      {.number = number, .sums = std::vector<double>(columns_), .counts = std::vector<std::int64_t>(columns_)});
}

void Grouping::add(Stretch& stretch, const ImportedRow& row) const {
  stretch.interval += row.interval;
  if (row.utc && !stretch.utc) stretch.utc = *row.utc - (row.time - map_.every * stretch.number);
  for (std::size_t i = 0; i < columns_; ++i) {
    const bool is_part =
        increments_.is_summed(i) ? increments_.is_counted(i, row.numbers) : !std::isnan(row.numbers[i]);
    if (!is_part) continue;
    stretch.sums[i] += row.numbers[i];
    ++stretch.counts[i];
  }
}

Result<void> Grouping::push(const ImportedRow& row) {
  const std::int64_t number = row.time / map_.every;
  if (first_ && number <= passed_on_) {
    if (map_.out_of_order == OutOfOrder::refuse)
      return failure(out_of_order(map_, map_.every * (passed_on_ + 1) - row.time, row.utc));
    ++left_out_;
    return {};
  }
  const auto position = std::ranges::lower_bound(open_, number, {}, &Stretch::number);
  add(stretch_at(position, number), row);
  while (open_.size() > most_open_)
    if (auto passed = pass_on_first(); !passed) return passed;
  return {};
}

Result<void> Grouping::pass_on_first() {
  Stretch stretch = std::move(open_.front());
  open_.pop_front();
  if (!first_) first_ = stretch.number;
  passed_on_ = stretch.number;
  for (std::size_t i = 0; i < columns_; ++i) {
    const auto count = static_cast<double>(stretch.counts[i]);
    if (count == 0) stretch.sums[i] = record::kMissing;
    if (!increments_.is_summed(i)) stretch.sums[i] /= count;
  }
  return take_({.time = map_.every * (stretch.number - *first_),
                .utc = stretch.utc,
                .interval = map_.counts_increments() ? stretch.interval : map_.every,
                .usual = map_.every,
                .numbers = stretch.sums});
}

Result<void> Grouping::finish() {
  while (!open_.empty())
    if (auto passed = pass_on_first(); !passed) return passed;
  return {};
}

}  // namespace gyrotherm::exchange
