// SPDX-License-Identifier: Apache-2.0
#include "drivers/gyro/host_time.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm::drivers {

namespace {

constexpr int kInstants = 60;  // one per second
// Maximum deviation of a line's delay from its usual delay.
constexpr double kMostLate_ns = 2e8;

constexpr double kPaceMemory_s = 30;
constexpr double kMostOff = 0.05, kMostOff_s = 0.3;
constexpr int kWrongAtLeast = 2;

}  // namespace

void HostInterval::count_from(Duration came) {
  newest_ = came;
  instants_ = std::max(instants_, 1);
}

std::optional<Duration> HostInterval::next(std::uint64_t rounds, Duration came) {
  const double expected_ns = static_cast<double>(rounds) * round_ns_;
  const double late_ns = static_cast<double>(passed(came).count()) - expected_ns;
  if (instants_ > 1 && std::abs(late_ns) > kMostLate_ns + round_ns_ / 2) return std::nullopt;
  const double n = instants_;
  const double g = 2 * (2 * n + 1) / ((n + 1) * (n + 2)), h = 6 / ((n + 1) * (n + 2));
  const Duration interval(std::llround(expected_ns + g * late_ns));
  if (interval <= Duration::zero()) return std::nullopt;
  newest_ += interval;
  if (!even_) return interval;
  round_ns_ += h * late_ns / static_cast<double>(rounds);
  instants_ = std::min(instants_ + 1, kInstants);
  return interval;
}

void FramePace::count_from(Duration came) {
  newest_ = came;
  judges_ = false;
  host_s_ = counted_s_ = 0;
  wrong_ = 0;
}

void FramePace::add(Duration counted, Duration came) {
  const double host_s = to_seconds(came - std::exchange(newest_, came));
  if (!std::exchange(judges_, true)) return;
  const double kept = std::exp(-host_s / kPaceMemory_s);
  host_s_ = host_s_ * kept + host_s;
  counted_s_ = counted_s_ * kept + to_seconds(counted);
  const double off_s = std::abs(host_s_ - counted_s_);
  const bool fits = off_s <= kMostOff * host_s_ + kMostOff_s + frame_s_;
  const bool is_far = off_s > host_s_ / 2;
  wrong_ = fits ? 0 : std::min(wrong_ + (is_far ? kWrongAtLeast : 1), kWrongAtLeast);
}

std::optional<double> FramePace::other_pace() const {
  constexpr double kLeast_s = 1e-3;
  if (wrong_ < kWrongAtLeast) return std::nullopt;
  return counted_s_ / std::max(host_s_, kLeast_s);
}

}  // namespace gyrotherm::drivers
