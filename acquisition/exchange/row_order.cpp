// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/row_order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "acquisition/exchange/channel_summary.hpp"
#include "acquisition/record/row.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kRowsAhead = 32;

/// Returns whether the row before may have had the time 23:59:60, which is parsed as 00:00:00 of the next day. So far,
/// leap seconds were inserted only after 30 June and 31 December.
bool may_follow_leap_second(std::optional<Duration> utc) {
  if (!utc) return false;
  const std::chrono::sys_time<Duration> at(*utc);
  const auto midnight = std::chrono::floor<std::chrono::days>(at);
  const std::chrono::year_month_day day(midnight);
  const bool is_half_year = day.month() == std::chrono::January || day.month() == std::chrono::July;
  return is_half_year && day.day() == std::chrono::day(1) && at - midnight < kSecond;
}

/// Returns another explanation that the size of the step back suggests, with the map key that can help.
std::string remedy(const ImportMap& map, Duration back) {
  constexpr double kWrapTolerance = 0.02;
  if (map.time_form == TimeForm::number && map.time_unit > Duration{} && map.time_unit < kSecond)
    for (const int bits : {16, 24, 31, 32}) {
      const double most = std::ldexp(1, bits), units = to_seconds(back) / to_seconds(map.time_unit);
      if (units > most * (1 - kWrapTolerance) && units <= most)
        return fmt::format(", or wrap = {:.0f} in [time] if a {}-bit counter wrapped around", most, bits);
    }
  const bool is_civil = map.time_form != TimeForm::number;
  const auto hour = std::chrono::hours(1);
  if (is_civil && back > hour * 9 / 10 && back <= hour)
    return ", or out_of_order = \"continue\" in [time] if the clock was put back for winter";
  if (back >= std::chrono::minutes(1))
    return ", or out_of_order = \"continue\" in [time] if the logger's clock restarted";
  return "";
}

}  // namespace

Fault out_of_order(const ImportMap& map, Duration back, std::optional<Duration> utc) {
  const auto how =
      back == Duration{} ? std::string("does not increase") : fmt::format("goes back {:g} s", to_seconds(back));
  const bool is_leap = back < kSecond && may_follow_leap_second(utc);
  return {FaultKind::bad_file, "",
          fmt::format("the time {}{}, expected one after the row before{}, or out_of_order = \"skip\" in [time]", how,
                      is_leap ? " (a leap second, 23:59:60, counts as 00:00:00)" : "", remedy(map, back))};
}

RowOrder::RowOrder(const ImportMap& map, TakeRow take)
    : map_(map), take_(std::move(take)), is_grouped_(map.every > Duration{}), increments_(map) {}

Result<void> RowOrder::push(const ForeignRow& row) {
  if (map_.out_of_order == OutOfOrder::refuse) {
    if (last_ && !is_after(row.time, *last_)) return failure(out_of_order(map_, *last_ - row.time, row.utc));
    return pass_on(row);
  }
  if (map_.out_of_order == OutOfOrder::shift) {
    ForeignRow moved = row;
    if (last_ && row.time + moved_ < *last_) {
      const Duration back = *last_ + step_ - (row.time + moved_);
      if (set_back_++ == 0) first_back_ = back - step_;
      moved_ += back;
    }
    moved.time += moved_;
    if (moved.utc) *moved.utc += moved_;
    if (moved.time > kLongestForeignTime || (moved.utc && !record::is_possible_time(*moved.utc)))
      return failure(FaultKind::bad_file, "",
                     fmt::format("the time is more than ten years after the first row or after 2116, because the clock "
                                 "was set back {} times; expected out_of_order = \"skip\" in [time]",
                                 set_back_));
    if (last_ && !is_after(moved.time, *last_)) return failure(out_of_order(map_, *last_ - moved.time, row.utc));
    return pass_on(moved);
  }
  if (last_ && !is_after(row.time, *last_)) {
    leave_out(row);
    return {};
  }
  held_.push_back({row.time, row.utc, {row.numbers.begin(), row.numbers.end()}});
  return held_.size() > kRowsAhead ? pop() : Result<void>{};
}

/// Returns whether the first held row belongs to a longest subsequence of the held rows that is in order.
bool RowOrder::is_front_in_order() const {
  const bool is_in_order = std::ranges::adjacent_find(held_, [&](const Held& a, const Held& b) {
                             return !is_after(b.time, a.time);
                           }) == held_.end();
  if (is_in_order) return true;
  std::array<std::size_t, kRowsAhead + 1> longest{};  // longest ordered subsequence from each row
  std::size_t most = 0;
  for (std::size_t i = held_.size(); i-- > 0;) {
    longest[i] = 1;
    for (std::size_t j = i + 1; j < held_.size(); ++j)
      if (is_after(held_[j].time, held_[i].time)) longest[i] = std::max(longest[i], longest[j] + 1);
    most = std::max(most, longest[i]);
  }
  return longest[0] == most;
}

Result<void> RowOrder::pop() {
  const bool is_good = is_front_in_order() && (!last_ || is_after(held_.front().time, *last_));
  const Held held = std::move(held_.front());
  held_.pop_front();
  const ForeignRow row{held.time, held.utc, held.numbers};
  if (is_good) return pass_on(row);
  leave_out(row);
  return {};
}

void RowOrder::leave_out(const ForeignRow& row) {
  ++left_out_;
  if (!increments_.has_any()) return;
  carried_.resize(row.numbers.size());
  for (std::size_t i = 0; i < carried_.size(); ++i)
    if (increments_.is_summed(i) && increments_.is_counted(i, row.numbers)) carried_[i] += row.numbers[i];
  carries_ = true;
}

Result<void> RowOrder::pass_on(const ForeignRow& row) {
  if (last_ && row.time > *last_) step_ = row.time - *last_;
  last_ = row.time;
  if (!carries_) return take_(row);
  added_.assign(row.numbers.begin(), row.numbers.end());
  for (std::size_t i = 0; i < added_.size(); ++i)
    if (increments_.is_summed(i)) added_[i] += std::exchange(carried_[i], 0);
  carries_ = false;
  return take_({row.time, row.utc, added_});
}

Result<void> RowOrder::finish() {
  while (!held_.empty())
    if (auto popped = pop(); !popped) return popped;
  return {};
}

std::string describe_rows_left_out(std::size_t rows) {
  return rows == 1 ? std::string("1 row was left out because its time was not after the previous row's")
                   : fmt::format("{} rows were left out because their time was not after the previous row's", rows);
}

void RowOrder::note(Notes& notes) const {
  if (left_out_ > 0) {
    auto note = describe_rows_left_out(left_out_);
    if (increments_.has_any())
      note += carries_ ? "; the increments of the last ones are lost"
                       : "; their increments are added to the rows that follow";
    notes.push_back(std::move(note));
  }
  if (set_back_ > 0)
    notes.push_back(
        fmt::format("the clock was set back {} time{}, at first by {:g} s: rows continue after the row before",
                    set_back_, set_back_ > 1 ? "s" : "", to_seconds(first_back_)));
}

}  // namespace gyrotherm::exchange
