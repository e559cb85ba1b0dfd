// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/host_time.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm::drivers {

namespace {

constexpr int kInstants = 60;  // one per second
// Maximum change of the line's delay between two reads.
constexpr double kMaxDelayChange_ns = 2e8;

constexpr double kPaceMemory_s = 30;
constexpr double kMaxDifference = 0.05, kMaxDifference_s = 0.3;
constexpr int kDeviationsForResult = 2;

}  // namespace

void HostInterval::start_at(Duration arrival) {
  newest_ = arrival;
  instants_ = std::max(instants_, 1);
}

std::optional<Duration> HostInterval::next(std::uint64_t rounds, Duration arrival) {
  const double expected_ns = static_cast<double>(rounds) * round_ns_;
  const double late_ns = static_cast<double>(time_since_start(arrival).count()) - expected_ns;
  if (instants_ > 1 && std::abs(late_ns) > kMaxDelayChange_ns + round_ns_ / 2) return std::nullopt;
  const double n = instants_;
  const double g = 2 * (2 * n + 1) / ((n + 1) * (n + 2)), h = 6 / ((n + 1) * (n + 2));
  const Duration interval(std::llround(expected_ns + g * late_ns));
  if (interval <= Duration::zero()) return std::nullopt;
  newest_ += interval;
  if (!has_regular_rate_) return interval;
  round_ns_ += h * late_ns / static_cast<double>(rounds);
  instants_ = std::min(instants_ + 1, kInstants);
  return interval;
}

void FramePace::start_at(Duration arrival) {
  newest_ = arrival;
  is_started_ = false;
  host_s_ = gyro_s_ = 0;
  deviations_ = 0;
}

void FramePace::add(Duration gyro_time, Duration arrival) {
  const double host_s = to_seconds(arrival - std::exchange(newest_, arrival));
  if (!std::exchange(is_started_, true)) return;
  const double decay = std::exp(-host_s / kPaceMemory_s);
  host_s_ = host_s_ * decay + host_s;
  gyro_s_ = gyro_s_ * decay + to_seconds(gyro_time);
  const double difference_s = std::abs(host_s_ - gyro_s_);
  const bool agrees = difference_s <= kMaxDifference * host_s_ + kMaxDifference_s + frame_s_;
  const bool is_far = difference_s > host_s_ / 2;
  deviations_ = agrees ? 0 : std::min(deviations_ + (is_far ? kDeviationsForResult : 1), kDeviationsForResult);
}

std::optional<double> FramePace::find_deviating_pace() const {
  constexpr double kLeast_s = 1e-3;
  if (deviations_ < kDeviationsForResult) return std::nullopt;
  return gyro_s_ / std::max(host_s_, kLeast_s);
}

}  // namespace gyrotherm::drivers
