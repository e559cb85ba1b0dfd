// SPDX-License-Identifier: Apache-2.0
/// Waiting times of a line: the rest period after failures, the pauses between exchanges, and the time since the last
/// exchange.
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

/// Decides when a line that failed may be tried again: immediately after the first failure, then after 0.5, 1, 2, 4, 8,
/// 10, 10, … s.
class Backoff {
 public:
  /// Uses `clock`, which must outlive this object; null means the steady clock.
  explicit Backoff(const Clock* clock = nullptr) : clock_(clock), next_(Duration::zero(), clock) {}
  void succeeded() { rest_ = Duration::zero(), failures_ = 0; }
  void failed();
  /// Allows the next try immediately. If it fails, the line rests as after a second failure.
  void end_rest() { rest_ = Duration::zero(); }
  /// Returns the remaining rest period; zero if the line may be tried.
  [[nodiscard]] Duration left() const { return rest_ == Duration::zero() ? rest_ : next_.left(); }
  /// Describes the rest period: "failed before, next try in 0.5 s".
  [[nodiscard]] std::string words() const;

 private:
  const Clock* clock_;
  int failures_ = 0;
  Duration rest_{};
  Deadline next_;
};

/// A clock and pauses measured by it.
class Pauses {
 public:
  virtual ~Pauses() = default;
  [[nodiscard]] virtual Duration now() const = 0;
  virtual void rest(Duration time) = 0;
};

/// Returns the machine's steady clock. A pause blocks the calling thread.
[[nodiscard]] std::unique_ptr<Pauses> real_pauses();
/// Returns a counter that each pause advances, for virtual instruments. A pause returns immediately.
[[nodiscard]] std::unique_ptr<Pauses> virtual_pauses();

/// Measures the time since a line was last active. One call may take many exchanges, which together may take many
/// seconds on a bad line; only a line without any exchange hangs. One thread writes, any thread reads.
class LineActivity {
 public:
  /// Notes the end of an exchange, successful or not, or of a part of a pause.
  void note() { last_ = now(); }
  /// Returns the time since the last note().
  [[nodiscard]] Duration quiet_for() const { return now() - last_.load(); }

 private:
  [[nodiscard]] static Duration now() { return std::chrono::steady_clock::now().time_since_epoch(); }
  std::atomic<Duration> last_{now()};
};

/// Returns registers that note the end of each call in `activity`.
[[nodiscard]] std::unique_ptr<Registers> noting(std::unique_ptr<Registers> registers,
                                                std::shared_ptr<LineActivity> activity);
/// Returns pauses that note every half second in `activity`.
[[nodiscard]] std::unique_ptr<Pauses> noting(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity);

}  // namespace gyrotherm::drivers
