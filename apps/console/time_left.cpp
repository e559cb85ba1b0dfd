// SPDX-License-Identifier: Apache-2.0
#include "apps/console/time_left.hpp"

namespace gyrotherm::app {

std::optional<Duration> TimeLeft::after(double fraction, Duration spent) {
  if (fraction != fraction_) {
    fraction_ = fraction;
    changed_ = spent;
  }
  if (fraction < 0.01 || fraction >= 1 || spent < std::chrono::seconds(2)) return {};
  const auto left = from_seconds(to_seconds(changed_) * (1 - fraction) / fraction) - (spent - changed_);
  return left > Duration{} ? std::optional(left) : std::nullopt;
}

}  // namespace gyrotherm::app
