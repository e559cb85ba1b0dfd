/// One run of a profile on a rig: the tick, once a second: read, step the profile, judge, command, store.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/store.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"
#include "rig/interlocks.hpp"
#include "rig/rig.hpp"
#include "rig/uploaded_program.hpp"
#include "sequencer/machine.hpp"
#include "sequencer/profile.hpp"

namespace gyrotherm {

enum class Outcome { going_on, complete, made_safe };

class Experiment {
 public:
  /// All of them outlive it. The rig has been prepared with the set point of `state`, which is that of slot
  /// `first_slot`.
  Experiment(const Profile& profile, Rig& rig, Store& store, State state, std::int64_t first_slot);

  /// One second, the one numbered `slot`; slots since the last one that had no tick become a recorded gap.
  /// Fails with storage alone: instruments' faults are recorded, and the interlocks judge them.
  [[nodiscard]] Result<Outcome> tick(std::int64_t slot);

  /// Sends the chamber to the rig's safe set point, and says in end_cause() whether it took it.
  void make_safe(const std::string& cause);

  /// The controller was given the profile and carries it out: from now on no set points are sent, time goes on while
  /// an instrument is silent, and a controller that no longer does it ends the run.
  void leave_to_the_controller() { watch_.emplace(); }
  [[nodiscard]] bool is_left_to_the_controller() const { return watch_.has_value(); }

  /// Puts an event into the record with the next tick.
  void note(EventKind kind, std::string text);

  /// Why the interlocks ended the run, and whether the chamber took the safe set point.
  [[nodiscard]] const std::string& end_cause() const { return end_cause_; }
  [[nodiscard]] std::int64_t next_slot() const { return next_slot_; }
  [[nodiscard]] const State& state() const { return state_; }
  /// Of the last tick; an empty one before the first.
  [[nodiscard]] const Sample& last() const { return last_; }

 private:
  void catch_up(std::int64_t slot);
  void note_changes(const Sample& sample);
  void send_set_point();
  void judge_controller(const Sample& sample, Duration elapsed, Verdict& verdict);
  Result<void> record_gap(std::int64_t slot);

  const Profile& profile_;
  Rig& rig_;
  Store& store_;
  State state_;
  std::int64_t next_slot_;
  InterlockMemory memory_;
  Reaction reaction_ = Reaction::go_on;
  std::optional<Celsius> air_;             ///< last known
  std::optional<Celsius> acknowledged_;    ///< what the chamber last took; nothing: unknown
  std::optional<ProgramWatch> watch_;      ///< of a controller that carries the profile out
  std::optional<std::int64_t> last_sent_;  ///< slot of the last set point
  int last_segment_ = -1;
  std::vector<bool> faulty_;         ///< per column: chamber, thermometers, gyro
  std::vector<std::string> alarms_;  ///< of the chamber, last seen
  std::vector<Event> events_;        ///< of the tick under way
  std::string end_cause_;
  Sample last_;
};

}  // namespace gyrotherm
