/// When a line that failed may be tried again: at once after the first failure, then after 0.5, 1, 2, 4, 8, 10, 10, …
/// s.
#pragma once

#include <string>

#include "drivers/line/deadline.hpp"

namespace gyrotherm {

class Backoff {
 public:
  /// `clock`, if given, must outlive this; without one the steady clock counts.
  explicit Backoff(const Clock* clock = nullptr) : clock_(clock), next_(Duration::zero(), clock) {}
  void succeeded() { rest_ = Duration::zero(), failures_ = 0; }
  void failed();
  /// It may be tried at once; if that fails too, it rests as after a second failure.
  void insist() { rest_ = Duration::zero(); }
  /// How long the line must rest still; zero: it may be tried.
  [[nodiscard]] Duration left() const { return rest_ == Duration::zero() ? rest_ : next_.left(); }
  /// "failed before, next try in 0.5 s"
  [[nodiscard]] std::string words() const;

 private:
  const Clock* clock_;
  int failures_ = 0;
  Duration rest_{};
  Deadline next_;
};

}  // namespace gyrotherm
