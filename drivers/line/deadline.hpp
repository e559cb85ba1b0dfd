/// The end of a wait on a line, by default on the steady clock, on which the kernel's waits run; a line in memory has a
/// clock of its own, which it moves.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/clock.hpp"
#include "core/quantity.hpp"

namespace gyrotherm {

class Deadline {
 public:
  explicit Deadline(Duration within) : end_(now() + within) {}
  /// `clock` must outlive this.
  Deadline(Duration within, const Clock* clock) : clock_(clock), end_(now() + within) {}
  /// What is left; zero once it is over.
  [[nodiscard]] Duration left() const { return std::max<Duration>(end_ - now(), Duration::zero()); }
  [[nodiscard]] bool over() const { return left() == Duration::zero(); }

 private:
  [[nodiscard]] Duration now() const {
    return clock_ != nullptr ? clock_->now().since_start
                             : Duration(std::chrono::steady_clock::now().time_since_epoch());
  }

  const Clock* clock_ = nullptr;  ///< none: the steady clock
  Duration end_;
};

}  // namespace gyrotherm
