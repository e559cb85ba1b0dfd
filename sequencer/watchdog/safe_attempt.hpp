// SPDX-License-Identifier: Apache-2.0
/// Makes one chamber safe. First it writes the safe set point and reads it back, without other requests, because on a
/// bad line each further request may be lost. Then it ends a program of the controller, writes the mode that follows
/// the set point, and switches conditioning off if the rig requires it. Finally it watches the air.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/watchdog/child_work.hpp"
#include "sequencer/watchdog/guard_post.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::watchdog {

/// Progress of an attempt.
enum class SafeStage {
  nothing,
  /// The chamber has shown the safe set point, the most important step.
  set_point,
  /// The chamber is also in the state that the rig requires.
  all,
};

/// The task of an attempt, in addition to sending the set point.
enum class SafeTask {
  /// Switch the chamber on or off only if the goal and the present mode require it.
  leave_as_required,
  /// Send the command to follow the set point, whatever the present mode.
  follow,
  /// Send the command to switch off, whatever the present mode.
  off,
  look,  ///< send nothing, only read
};

struct SafeAttempt {
  SafeStage reached{};
  /// Number of attempts to send the set point.
  int tries{};
  /// Current state, or the last fault.
  std::string details;
  std::optional<ChamberState> state;  ///< the last one read
};

/// Suffix of the lock's description while the chamber is made safe.
inline constexpr std::string_view kMadeSafeMark = " (being made safe)";

/// The environment of an attempt.
struct AttemptEnvironment {
  /// Makes a new connection, which has no pending pause and no stale reply.
  std::function<std::unique_ptr<drivers::Chamber>()> connect;
  std::function<void(Duration)> wait;
  /// Receives each stage reached, and each fault.
  std::function<void(const SafeAttempt&)> report;
  const Clock& clock;
};

/// Time limit for sending the set point to a chamber that answers.
inline constexpr Duration kSafeWithin = std::chrono::seconds(10);

/// Sends the set point repeatedly for up to eight seconds, on one connection, or on a new one after a line failure.
/// Once the chamber has shown the set point, carries out the remaining steps, at most three times.
[[nodiscard]] SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptEnvironment& environment,
                                       SafeTask task = SafeTask::leave_as_required);

struct SafeStateChamber {
  std::string place;  ///< names its lock (drivers/chamber/chamber_lock.hpp)
  SafeGoal goal;
  std::function<std::unique_ptr<drivers::Chamber>()> connect;
};
/// Returns the chamber that the safe-state file describes, by its map. Fails with bad_file.
[[nodiscard]] Result<SafeStateChamber> make_safe_state_chamber(const SafeState& safe_state);

struct RescueResult {
  SafeStage reached{};
  std::string details;
  /// Another program holds the chamber: nothing was attempted.
  bool in_use{};
  std::string holder{};  ///< describes the other program
  /// The later run that has taken the chamber over, with a guard of its own; empty: none. Nothing was attempted.
  std::string successor{};
  std::optional<ChamberState> state{};
  /// The chamber has shown the safe set point and a safe mode; only the air is still watched.
  bool has_shown_commands{};
  /// The air does not behave as in a safe chamber.
  bool is_ineffective{};
};

/// Makes one attempt and holds the chamber's lock meanwhile. If another program holds the lock, makes the attempt
/// anyway, because a dying program keeps its lock while a disk access hangs, and a third-party program with the lock
/// must not keep a chamber hot. The exception is a holder that drives chambers or makes them safe, belongs to this user
/// or root, is not stopped, and is not the program that has died. Attempts nothing once a later run has reported to
/// `post` that it has taken the chamber over; a run reports this while it holds the lock, so a report is never later
/// than the lock. Ends a hanging attempt after ten seconds, or thirty seconds later if the chamber has shown the safe
/// set point, and in any case after `at_most`.
[[nodiscard]] RescueResult attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, GuardPost& post,
                                        SafeTask task = SafeTask::leave_as_required,
                                        Duration at_most = Duration::max());

/// Makes a chamber safe by repeated attempts. Each attempt opens and closes its own connection, so a program that takes
/// the run over finds the chamber free. The readings of all attempts form one body of evidence. Holds a post, so other
/// programs find the waiting guard.
class SafeRescue {
 public:
  /// All arguments must outlive this object.
  SafeRescue(const SafeState& safe_state, const SafeStateChamber& chamber, ErrorPrinter& printer)
      : safe_state_(safe_state),
        chamber_(chamber),
        printer_(printer),
        post_(chamber.place, safe_state.written_by.pid),
        evidence_(chamber.goal) {}

  /// Sends the commands that are due, or reads the chamber, for at most `at_most`. `reached` is `all` only once the
  /// chamber has shown set point, mode and air.
  [[nodiscard]] RescueResult attempt(Duration at_most = Duration::max());
  /// Returns true if every remedy has failed and only an operator can help.
  [[nodiscard]] bool is_exhausted() const { return evidence_.is_exhausted(); }
  /// Returns true if the chamber has never answered, or has not answered in the last kLostAfter attempts.
  [[nodiscard]] bool is_lost() const { return !has_answered_ || failures_ >= kLostAfter; }
  /// Returns the pause before the next attempt.
  [[nodiscard]] Duration pause() const;

 private:
  [[nodiscard]] SafeTask task() const;
  void take(const RescueResult& rescued, SafeTask task);

  const SafeState& safe_state_;
  const SafeStateChamber& chamber_;
  ErrorPrinter& printer_;
  GuardPost post_;
  SafeEvidence evidence_;
  static constexpr int kLostAfter = 5;

  bool is_answering_ = false;  ///< in the last attempt
  bool has_answered_ = false;
  int failures_ = 0;
  /// The program that last held the chamber, which is reported once.
  std::string holder_;
};

}  // namespace gyrotherm::watchdog
