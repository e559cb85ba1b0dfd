// SPDX-License-Identifier: Apache-2.0
/// Waiting times of a line: the rest of a line that failed, the pauses between exchanges, and the time since the last
/// exchange ended.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>

#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/quantity.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Decides when a line that failed may be tried again: at once after the first failure, then after 0.5, 1, 2, 4, 8, 10,
/// 10, … s.
class Backoff {
 public:
  /// `clock`, if given, must outlive this; without one the steady clock counts.
  explicit Backoff(const Clock* clock = nullptr) : clock_(clock), next_(Duration::zero(), clock) {}
  void succeeded() { rest_ = Duration::zero(), failures_ = 0; }
  void failed();
  /// Allows the next try at once. If that fails too, the line rests as after a second failure.
  void end_rest() { rest_ = Duration::zero(); }
  /// Returns the remaining rest; zero if the line may be tried.
  [[nodiscard]] Duration left() const { return rest_ == Duration::zero() ? rest_ : next_.left(); }
  /// Describes the rest: "failed before, next try in 0.5 s".
  [[nodiscard]] std::string words() const;

 private:
  const Clock* clock_;
  int failures_ = 0;
  Duration rest_{};
  Deadline next_;
};

/// A clock, and rests on it.
class Pauses {
 public:
  virtual ~Pauses() = default;
  [[nodiscard]] virtual Duration now() const = 0;
  virtual void rest(Duration time) = 0;
};

/// Returns the machine's steady clock. A rest blocks the calling thread.
[[nodiscard]] std::unique_ptr<Pauses> real_pauses();
/// Returns a counter that each rest advances, for virtual instruments. A rest returns at once.
[[nodiscard]] std::unique_ptr<Pauses> virtual_pauses();

/// Measures how long a line has been quiet. A call may take many exchanges, each with a limit of its own, which add up
/// to many seconds on a bad line; only a line that stays quiet hangs. One thread writes, any thread reads.
class LineActivity {
 public:
  /// Notes that an exchange has ended, successful or not, or that a part of a rest is over.
  void note() { last_ = now(); }
  /// Returns the time since the last note().
  [[nodiscard]] Duration quiet_for() const { return now() - last_.load(); }

 private:
  [[nodiscard]] static Duration now() { return std::chrono::steady_clock::now().time_since_epoch(); }
  std::atomic<Duration> last_{now()};
};

/// Returns the same registers. Each call that returns is noted in `activity`.
[[nodiscard]] std::unique_ptr<Registers> noting(std::unique_ptr<Registers> registers,
                                                std::shared_ptr<LineActivity> activity);
/// Returns the same pauses. A long rest is noted every half second.
[[nodiscard]] std::unique_ptr<Pauses> noting(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity);

}  // namespace gyrotherm::drivers
