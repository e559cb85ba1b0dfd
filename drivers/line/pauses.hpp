// SPDX-License-Identifier: Apache-2.0
/// Times of a line: the rest period after failures, the pauses between exchanges, and the time since the last exchange.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>

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
  void note_success() { rest_ = Duration::zero(), failures_ = 0; }
  /// Begins a rest period after the second failure in a row. `cause` appears in the message.
  void note_failure(std::string_view cause);
  /// Ends the rest period. If the next attempt fails too, the next rest period is again the shortest one.
  void end_rest() { rest_ = Duration::zero(); }
  /// Returns the remaining rest period; zero if the line may be tried.
  [[nodiscard]] Duration left() const { return rest_ == Duration::zero() ? rest_ : next_.left(); }
  /// Returns the cause of the failure and the time until the next attempt: "Connection refused; next try in 0.5 s".
  [[nodiscard]] std::string message() const;

 private:
  const Clock* clock_;
  int failures_ = 0;
  std::string cause_;
  Duration rest_{};
  Deadline next_;
};

/// A clock, and pauses that are measured by this clock.
class Pauses {
 public:
  virtual ~Pauses() = default;
  [[nodiscard]] virtual Duration now() const = 0;
  virtual void rest(Duration time) = 0;
};

/// Returns the machine's steady clock. A pause blocks the calling thread.
[[nodiscard]] std::unique_ptr<Pauses> make_real_pauses();
/// Returns a virtual clock, for virtual instruments. A pause only advances it and returns immediately.
[[nodiscard]] std::unique_ptr<Pauses> make_virtual_pauses();

/// Measures the time since the last exchange on a line, to detect a line that hangs: on a bad line, one call may take
/// many seconds, but its exchanges end. Only one thread may call note(); any thread may call time_since_note().
class LineActivity {
 public:
  /// Notes the end of an exchange, even a failed one, or the end of a part of a pause.
  void note() { last_ = now(); }
  /// Returns the time since the last note().
  [[nodiscard]] Duration time_since_note() const { return now() - last_.load(); }

 private:
  [[nodiscard]] static Duration now() { return std::chrono::steady_clock::now().time_since_epoch(); }
  std::atomic<Duration> last_{now()};
};

/// Wraps `registers`: every call ends with activity->note().
[[nodiscard]] std::unique_ptr<Registers> record_activity(std::unique_ptr<Registers> registers,
                                                         std::shared_ptr<LineActivity> activity);
/// Wraps `pauses`: every pause calls activity->note() each half second and at its end.
[[nodiscard]] std::unique_ptr<Pauses> record_activity(std::unique_ptr<Pauses> pauses,
                                                      std::shared_ptr<LineActivity> activity);

}  // namespace gyrotherm::drivers
