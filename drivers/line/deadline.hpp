/// The end of a wait on a line. The kernel's waits run on the steady clock, so this does too.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/quantity.hpp"

namespace gyrotherm {

class Deadline {
 public:
  explicit Deadline(Duration within) : end_(std::chrono::steady_clock::now() + within) {}
  /// What is left; zero once it is over.
  [[nodiscard]] Duration left() const {
    return std::max<Duration>(end_ - std::chrono::steady_clock::now(), Duration::zero());
  }
  [[nodiscard]] bool over() const { return left() == Duration::zero(); }

 private:
  std::chrono::steady_clock::time_point end_;
};

}  // namespace gyrotherm
