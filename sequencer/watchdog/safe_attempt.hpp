// SPDX-License-Identifier: Apache-2.0
/// Making one chamber safe: its safe set point first, written and read back with nothing else asked on the way, for on
/// a bad line each question more is one that may be lost; then a program of the controller's own ended, the mode that
/// follows the set point written, and conditioning ended where the rig wants it; then the air watched.
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
#include "sequencer/watchdog/safe_evidence.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::watchdog {

/// How far an attempt has come.
enum class SafeStage {
  nothing,
  set_point,  ///< the chamber has shown the safe set point: what matters most
  all,        ///< the chamber is also left as the rig wants it
};

/// The task of an attempt beside sending the set point.
enum class SafeTask {
  leave_as_wanted,  ///< by the goal and the mode
  follow,           ///< write the mode in any case
  off,              ///< switch off in any case
  look,             ///< send nothing, read alone
};

struct SafeAttempt {
  SafeStage reached{};
  int tries{};                        ///< how often the set point was sent
  std::string details;                ///< what the chamber says now, or the last fault
  std::optional<ChamberState> state;  ///< the last one read
};

/// Ends what the chamber's lock is taken for while it is made safe.
inline constexpr std::string_view kMadeSafeMark = " (made safe)";

/// What an attempt needs of the world.
struct AttemptMeans {
  std::function<std::unique_ptr<drivers::Chamber>()> connect;  ///< a new connection: no rest, no stale reply
  std::function<void(Duration)> wait;
  std::function<void(const SafeAttempt&)> told;  ///< is told each stage that is reached, and each fault
  const Clock& clock;
};

inline constexpr Duration kSafeWithin = std::chrono::seconds(10);  ///< the set point, if the chamber answers

/// Tries the set point again and again on one connection (on a new one after a line that broke), the last time before
/// eight seconds are over; once the chamber has shown it, the rest, three times at most.
[[nodiscard]] SafeAttempt attempt_safe(const SafeGoal& goal, const AttemptMeans& means,
                                       SafeTask task = SafeTask::leave_as_wanted);

struct SafeStateChamber {
  std::string place;  ///< names its lock (drivers/chamber/chamber_lock.hpp)
  SafeGoal goal;
  std::function<std::unique_ptr<drivers::Chamber>()> connect;
};
/// The chamber that the safe-state file describes, by its map. Fails with bad_file.
[[nodiscard]] Result<SafeStateChamber> chamber_of(const SafeState& safe_state);

struct Rescued {
  SafeStage reached{};
  std::string details;
  bool in_use{};     ///< another program has the chamber by now: nothing was tried
  bool is_driven{};  ///< that program drives it, and does not make it safe
  std::optional<ChamberState> state{};
};

/// Holds the chamber's lock meanwhile. Without it, it acts all the same, unless a program of this user or of root that
/// drives chambers or makes them safe has it by now, does not stand still, and is not the one that has gone: one that
/// is dying keeps its lock while it hangs in the disk, and a stranger who holds it must not keep a chamber hot. An
/// attempt that hangs is ended, after ten seconds or, once the chamber has shown the safe set point, after thirty
/// more.
[[nodiscard]] Rescued attempt_once(const SafeState& safe_state, const SafeStateChamber& chamber, Voice& voice,
                                   SafeTask task = SafeTask::leave_as_wanted);

/// Makes a chamber safe by attempts, each on a connection of its own so that a program that takes the run over finds
/// the chamber free, and judges what the chamber has shown in all of them.
class SafeRescue {
 public:
  /// All of them outlive it.
  SafeRescue(const SafeState& safe_state, const SafeStateChamber& chamber, Voice& voice)
      : safe_state_(safe_state), chamber_(chamber), voice_(voice), evidence_(chamber.goal) {}

  /// Commands what is due, or looks at the chamber. `reached` is all only once set point, mode and air are shown.
  [[nodiscard]] Rescued attempt();
  /// Returns true if no means has made the chamber safe: only people can help.
  [[nodiscard]] bool is_out_of_means() const { return evidence_.is_out_of_means(); }
  /// Returns true if the chamber has not been read at all, or not in the last attempts.
  [[nodiscard]] bool is_lost() const { return !was_in_touch_ || failures_ >= kLostAfter; }
  /// Returns the pause before the next attempt.
  [[nodiscard]] Duration pause() const;

 private:
  [[nodiscard]] SafeTask task() const;
  void take(const Rescued& rescued, SafeTask task);

  const SafeState& safe_state_;
  const SafeStateChamber& chamber_;
  Voice& voice_;
  SafeEvidence evidence_;
  static constexpr int kLostAfter = 5;

  bool in_touch_ = false;  ///< in the last attempt
  bool was_in_touch_ = false;
  int failures_ = 0;
};

}  // namespace gyrotherm::watchdog
