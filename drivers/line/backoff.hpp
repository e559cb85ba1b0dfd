/// When a line that failed may be tried again: at once after the first failure, then after 0.5, 1, 2, 4, 8, 10, 10, …
/// s.
#pragma once

#include "drivers/line/deadline.hpp"

namespace gyrotherm {

class Backoff {
 public:
  void succeeded() { rest_ = Duration::zero(), failures_ = 0; }
  void failed();
  /// How long the line must rest still; zero: it may be tried.
  [[nodiscard]] Duration left() const { return rest_ == Duration::zero() ? rest_ : next_.left(); }

 private:
  int failures_ = 0;
  Duration rest_{};
  Deadline next_{Duration::zero()};
};

}  // namespace gyrotherm
