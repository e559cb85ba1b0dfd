// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/deadline.hpp"

#include <fmt/format.h>

namespace gyrotherm::drivers {

void Backoff::failed() {
  using std::chrono::milliseconds;
  constexpr Duration kFirst = milliseconds(500), kLongest = milliseconds(10'000);
  if (++failures_ < 2) return;
  rest_ = std::clamp(2 * rest_, kFirst, kLongest);
  next_ = Deadline(rest_, clock_);
}

std::string Backoff::words() const { return fmt::format("failed before, next try in {:.1f} s", to_seconds(left())); }

}  // namespace gyrotherm::drivers
