// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/grouping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "acquisition/record/row.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kMostRowsHeldBack = 1 << 16, kMostNumbersHeldBack = 1 << 22;

/// Whether the row before may have had the time 23:59:60, which counts as 00:00:00: so far they were put in after
/// 30 June and 31 December alone.
bool may_follow_leap_second(std::optional<Duration> utc) {
  if (!utc) return false;
  const std::chrono::sys_time<Duration> at(*utc);
  const auto midnight = std::chrono::floor<std::chrono::days>(at);
  const std::chrono::year_month_day day(midnight);
  const bool is_half_year = day.month() == std::chrono::January || day.month() == std::chrono::July;
  return is_half_year && day.day() == std::chrono::day(1) && at - midnight < kSecond;
}

tl::unexpected<Fault> out_of_order(Duration back, std::optional<Duration> utc) {
  const auto how =
      back == Duration{} ? std::string("does not increase") : fmt::format("goes back {:g} s", to_seconds(back));
  const bool is_leap = back < kSecond && may_follow_leap_second(utc);
  return failure(FaultKind::bad_file, "",
                 fmt::format("the time {}{}, expected one after the row before, or out_of_order = \"skip\" in [time]",
                             how, is_leap ? " (a leap second, 23:59:60, counts as 00:00:00)" : ""));
}

}  // namespace

Result<void> Spacing::push(const ForeignRow& row) {
  if (last_ && row.time <= *last_) {
    if (!map_.skips_out_of_order) return out_of_order(*last_ - row.time, row.utc);
    ++left_out_;
    return {};
  }
  if (!first_) first_ = row.time;
  const auto since_before = last_ ? std::optional(row.time - *last_) : std::nullopt;
  last_ = row.time;
  if (usual_ > Duration{}) return hand_on(row, since_before);
  hold_back(row);
  const bool is_enough = times_.size() == kMostRowsHeldBack || numbers_.size() >= kMostNumbersHeldBack;
  return is_enough && times_.size() > 1 ? finish() : Result<void>{};
}

void Spacing::hold_back(const ForeignRow& row) {
  times_.push_back(row.time);
  utcs_.push_back(row.utc);
  numbers_.insert(numbers_.end(), row.numbers.begin(), row.numbers.end());
}

Result<void> Spacing::hand_on(const ForeignRow& row, std::optional<Duration> since_before) {
  const bool since_row_before = map_.time && map_.counts_increments() && since_before;
  return take_({.time = row.time - *first_,
                .utc = row.utc,
                .interval = since_row_before ? *since_before : usual_,
                .usual = usual_,
                .numbers = row.numbers});
}

Result<void> Spacing::finish() {
  if (times_.empty()) return {};
  usual_ = usual_step(times_);
  const std::size_t columns = numbers_.size() / times_.size();
  for (std::size_t i = 0; i < times_.size(); ++i) {
    const auto since_before = i > 0 ? std::optional(times_[i] - times_[i - 1]) : std::nullopt;
    const auto numbers = std::span<const double>(numbers_).subspan(i * columns, columns);
    if (auto handed = hand_on({times_[i], utcs_[i], numbers}, since_before); !handed) return handed;
  }
  times_ = {};
  utcs_ = {};
  numbers_ = {};
  return {};
}

Grouping::Grouping(const ImportMap& map, TakeImported take)
    : map_(map), take_(std::move(take)), columns_(map.columns().size()) {
  if (!map.counts_increments()) return;
  first_sum_ = map.thermometer_columns.size();
  end_of_sums_ = first_sum_ + map.axis_columns.size();
}

Grouping::Stretch& Grouping::stretch_at(std::deque<Stretch>::iterator place, std::int64_t number) {
  if (place != open_.end() && place->number == number) return *place;
  return *open_.insert(
      place, {.number = number, .sums = std::vector<double>(columns_), .counts = std::vector<std::int64_t>(columns_)});
}

void Grouping::add(Stretch& stretch, const ImportedRow& row) const {
  stretch.interval += row.interval;
  if (row.utc && !stretch.utc) stretch.utc = *row.utc - (row.time - map_.every * stretch.number);
  for (std::size_t i = 0; i < columns_; ++i) {
    if (std::isnan(row.numbers[i]) && !is_increment(i)) continue;
    stretch.sums[i] += row.numbers[i];
    ++stretch.counts[i];
  }
}

Result<void> Grouping::push(const ImportedRow& row) {
  const std::int64_t number = row.time / map_.every;
  if (first_ && number <= handed_on_) {
    if (!map_.skips_out_of_order) return out_of_order(map_.every * (handed_on_ + 1) - row.time, row.utc);
    ++left_out_;
    return {};
  }
  const auto place = std::ranges::lower_bound(open_, number, {}, &Stretch::number);
  add(stretch_at(place, number), row);
  while (open_.size() > 2)
    if (auto handed = hand_on_first(); !handed) return handed;
  return {};
}

Result<void> Grouping::hand_on_first() {
  Stretch stretch = std::move(open_.front());
  open_.pop_front();
  if (!first_) first_ = stretch.number;
  handed_on_ = stretch.number;
  for (std::size_t i = 0; i < columns_; ++i) {
    const auto count = static_cast<double>(stretch.counts[i]);
    if (count == 0) stretch.sums[i] = record::kMissing;
    if (!is_increment(i)) stretch.sums[i] /= count;
  }
  return take_({.time = map_.every * (stretch.number - *first_),
                .utc = stretch.utc,
                .interval = map_.counts_increments() ? stretch.interval : map_.every,
                .usual = map_.every,
                .numbers = stretch.sums});
}

Result<void> Grouping::finish() {
  while (!open_.empty())
    if (auto handed = hand_on_first(); !handed) return handed;
  return {};
}

}  // namespace gyrotherm::exchange
