// SPDX-License-Identifier: Apache-2.0
/// One run of a profile on a rig: the tick, once a second: read, judge, step the procedure and the profile, command,
/// store.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/record/store.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/run/chamber_lead.hpp"
#include "sequencer/run/dropped_units.hpp"
#include "sequencer/run/operator_requests.hpp"
#include "sequencer/run/rig_changes.hpp"
#include "sequencer/run/run_state_machine.hpp"
#include "sequencer/run/run_tally.hpp"
#include "sequencer/run/safe_sequence.hpp"

namespace gyrotherm::run {

enum class RunOutcome { going_on, complete, stopped, made_safe };

class RunController {
 public:
  /// All of them outlive it. The rig has been prepared with the set point of `state`, which is that of slot
  /// `first_slot`.
  RunController(const profile::Profile& profile, rig::Rig& rig, record::Store& store, profile::ProfileState state,
                std::int64_t first_slot);

  /// Before the first tick: the rig was prepared with another set point, `here`. The run begins on its way from there
  /// to the profile, by a ramp, and the profile's clock stands still until the air has followed, or is within 2 K of
  /// `air_before`, where it was when the run stopped. `cause`: why it begins elsewhere.
  void begin_away(Celsius here, const std::string& cause, std::optional<Celsius> air_before);

  /// One second, the one numbered `slot`; slots since the last one that had no tick become a recorded gap, in which the
  /// profile's clock stands still.
  /// Fails with storage alone: instruments' faults are recorded, and the interlocks judge them. Ends with made_safe or
  /// stopped only after the chamber has shown that it is as it is to be left.
  [[nodiscard]] Result<RunOutcome> tick(std::int64_t slot);

  /// Why an operator's command would not be carried out with the next tick; empty: it will.
  [[nodiscard]] std::string objection(OperatorCommand command) const;
  /// An operator's command and what they say to it, recorded with the next tick, which carries out the most severe of
  /// those that came before it.
  void submit(OperatorCommand command, const std::string& who, const std::string& answer = {});
  /// Before the first tick: units that were dropped from the run before.
  void leave_out(std::span<const std::string> units) { dropped_.drop(units); }
  /// Before the first tick of a resumed run: the counts of what was recorded before.
  void continue_tally(const RunTally& tally) { tally_ = tally; }
  [[nodiscard]] const RunTally& tally() const { return tally_; }
  /// Takes what an operator asks for the next tick and says so, or says why not. Either way it is in the record, with
  /// who it was.
  [[nodiscard]] control::ControlAnswer carry_out(const control::ControlRequest& request, const std::string& who);
  /// An operator has asked for the run's end, and the next tick will begin it.
  [[nodiscard]] bool is_told_to_end() const { return requests_.end_the_run(); }

  /// Somebody was answered, or something happened, that the next tick will put into the record and act on.
  [[nodiscard]] bool owes_a_tick() const { return !events_.empty() || requests_.foremost() != nullptr; }

  /// Makes the chamber safe without a tick, for an end that cannot wait for one; end_cause() says whether it could be.
  /// The air is left to the guard to watch.
  void make_safe(const std::string& cause);

  /// Before the first tick: the chamber's controller was given the profile, and leads the chamber instead of this
  /// program.
  void leave_to_the_controller();
  [[nodiscard]] bool is_left_to_the_controller() const { return lead_->can_continue_alone(); }

  /// Returns in words how the last reading shows that another has changed the chamber; empty: it does not.
  [[nodiscard]] std::string foreign_hold() const;

  /// Takes, by subject, why the chamber would not be made safe if this program died now; empty: it would be. It counts
  /// from the next tick on.
  void see_guard(std::map<std::string, std::string> troubles) { guard_troubles_ = std::move(troubles); }

  /// Puts an event into the record with the next tick.
  void note(EventKind kind, std::string text, EventSubject about = {});

  /// Why the run ended, or is being ended, and whether the chamber is safe.
  [[nodiscard]] std::string end_cause() const;
  /// Returns true if the chamber has shown the safe set point, the mode that follows it, and its air.
  [[nodiscard]] bool is_safe() const { return safe_.is_confirmed(); }
  [[nodiscard]] std::int64_t next_slot() const { return next_slot_; }
  [[nodiscard]] const profile::ProfileState& state() const { return state_; }
  /// Returns the last tick's sample; an empty one before the first tick.
  [[nodiscard]] const Sample& last() const { return last_; }
  /// What the last tick put into the record, in order.
  [[nodiscard]] const std::vector<Event>& last_events() const { return last_events_; }
  [[nodiscard]] RunState run_state() const { return run::run_state(machine_); }
  [[nodiscard]] RunStanding standing() const;

 private:
  [[nodiscard]] control::ControlAnswer drop_or_return(const control::UnitRequest& request, const std::string& who,
                                                      const std::string& why);
  /// Acknowledges the alarms of these numbers and their consequences; all alarms if there is no number.
  [[nodiscard]] control::ControlAnswer acknowledge(const std::vector<std::int64_t>& numbers, const std::string& who,
                                                   const std::string& comment);
  struct Acknowledged {
    std::size_t count{};
    std::vector<std::string> objections{};  ///< one for each that is not
  };
  /// Writes to the record at once, so that the next request finds the alarms acknowledged.
  [[nodiscard]] Acknowledged append_acknowledgements(const std::vector<std::int64_t>& numbers, const std::string& who,
                                                     const std::string& comment);
  Result<void> record_gap(std::int64_t slot);
  void note_changes(const Sample& sample);
  void note_all(std::vector<RigChange> changes);
  [[nodiscard]] interlocks::InterlockInputs inputs(const Sample& sample, Duration missed) const;
  [[nodiscard]] interlocks::InterlockDemand judge_second(const Sample& sample, Duration missed);
  /// What the lead sees of this second, at the profile's present state.
  [[nodiscard]] LeadSecond second(const Sample& sample, Duration missed) const;
  /// Whether a command ends what somebody else's set point holds: of that its operator can know.
  [[nodiscard]] bool takes_over(control::OperatorCommand command) const;
  /// The cause, as of the last second, for which no more than this is demanded; empty: none, or more.
  [[nodiscard]] std::string standing_cause(interlocks::Reaction reaction, bool takes_over) const;
  /// What an operator is told who asks for it without an objection.
  [[nodiscard]] std::string answer_to(control::OperatorCommand command) const;
  /// What of the last second that was judged is against a command.
  [[nodiscard]] std::string standing_objection(control::OperatorCommand command, bool takes_over) const;
  [[nodiscard]] std::optional<OperatorRequest> take_request();
  void see_safe(const Sample& sample);
  [[nodiscard]] std::string prompt_of(const Sample& sample);
  void step_machine(const Sample& sample, const interlocks::InterlockDemand& demand, Duration missed);
  void change_to(RunStateMachine machine);
  void step_profile(const Sample& sample);
  [[nodiscard]] profile::Observation observation(const Sample& sample) const;
  void note_soak(const ProfilePosition& before);
  void command_chamber(const Sample& sample);

  const profile::Profile& profile_;
  rig::Rig& rig_;
  record::Store& store_;
  profile::ProfileState state_;
  std::int64_t next_slot_;
  RunStateMachine machine_ = Execute{};
  interlocks::InterlockMemory memory_;
  std::unique_ptr<ChamberLead> lead_;
  SafeSequence safe_;
  DroppedUnits dropped_;
  const std::vector<record::Channel> channels_;
  RigChanges changes_;
  RunTally tally_;
  Duration planned_;            ///< the whole profile, if every soak counts at once
  std::optional<Celsius> air_;  ///< last known
  OperatorRequests requests_;
  interlocks::InterlockDemand demand_;  ///< of the last second that was judged
  int last_segment_ = -1;
  int answered_ = -1;               ///< the last segment that has had its prompt
  std::vector<Event> events_;       ///< what the tick under way will put into the record
  std::vector<Event> last_events_;  ///< what the last tick put into it
  std::map<std::string, std::string> guard_troubles_;
  Sample last_;
};

}  // namespace gyrotherm::run
