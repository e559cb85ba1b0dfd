// SPDX-License-Identifier: Apache-2.0
/// How long to wait before what failed is tried again: twice as long each time up to a longest wait, and of that a part
/// by chance, so that a hundred rigs that lost their store together do not all come back in the same second.
#pragma once

#include <algorithm>
#include <random>

#include "core/quantity.hpp"
#include "core/random.hpp"

namespace gyrotherm::site {

class Backoff {
 public:
  explicit Backoff(Duration longest, std::uint64_t seed) : longest_(longest), generator_(seed) {}

  /// What to wait now: between half of the wait and all of it. The next one is twice as long.
  [[nodiscard]] Duration next() {
    const auto whole = std::min(wait_, longest_);
    wait_ = std::min(wait_ * 2, longest_);
    return std::chrono::duration_cast<Duration>(whole * (0.5 + 0.5 * uniform(generator_)));
  }
  /// It worked: the next wait is a short one again.
  void reset() { wait_ = kFirst; }

 private:
  static constexpr Duration kFirst = std::chrono::milliseconds(250);
  Duration longest_;
  Duration wait_ = kFirst;
  std::mt19937_64 generator_;
};

}  // namespace gyrotherm::site
