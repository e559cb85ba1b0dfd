// SPDX-License-Identifier: Apache-2.0
/// One run of a profile on a rig. Once a second, a tick reads the instruments, evaluates the interlocks, advances the
/// state machines of the run and of the profile, commands the chamber and stores the sample.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/record/decision.hpp"
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
#include "sequencer/run/safe_relay.hpp"
#include "sequencer/run/safe_sequence.hpp"
#include "sequencer/run/unit_power.hpp"

namespace gyrotherm::run {

enum class RunOutcome { going_on, complete, stopped, made_safe };

class RunController {
 public:
  /// `rig` and `store` must outlive this object. The rig must be prepared with the set point of `state`, the state of
  /// slot `first_slot`.
  RunController(const profile::Profile& profile, rig::Rig& rig, record::Store& store, profile::ProfileState state,
                std::int64_t first_slot);

  /// Starts with the chamber away from the profile. Call it before the first tick if the rig was prepared with another
  /// set point, `here`. The run returns to the profile by a ramp. The profile's clock is stopped until the air is
  /// within 2 K of the set point, or of `air_before`, the air temperature when the run stopped. `cause` is the reason
  /// that is recorded.
  void begin_away(Celsius here, const std::string& cause, std::optional<Celsius> air_before);
  /// Begins with the set point at the air temperature `here`, within kResumeBand of the profile. The profile's clock
  /// runs while the set point ramps to the profile.
  void begin_behind(Celsius here);

  /// Carries out the second numbered `slot`. Slots without a tick since the last one become a recorded gap, in which
  /// the profile's clock does not run. Fails with storage only: faults of instruments are recorded, and the interlocks
  /// judge them. Returns made_safe or stopped only after the chamber has shown its final state.
  [[nodiscard]] Result<RunOutcome> tick(std::int64_t slot);

  /// Returns the reason why the next tick would not carry out an operator's command; empty if it will.
  [[nodiscard]] std::string refusal_reason(OperatorCommand command) const;
  /// Records an operator's command and its text with the next tick, which carries out the most severe waiting command.
  void submit(OperatorCommand command, const std::string& who, const std::string& answer = {});
  /// Drops units that were dropped before a resume. Call it before the first tick.
  void leave_out(std::span<const std::string> units) { dropped_.drop(units); }
  /// Continues the counts of a resumed run. Call it before the first tick.
  void continue_tally(const RunTally& tally) { tally_ = tally; }
  [[nodiscard]] const RunTally& tally() const { return tally_; }
  /// Accepts an operator's request for the next tick, or refuses it, and returns the answer. Records both cases with
  /// the operator's name.
  [[nodiscard]] control::ControlAnswer carry_out(const control::ControlRequest& request, const std::string& who);
  /// Returns true if an operator has requested the run's end and the next tick will begin it.
  [[nodiscard]] bool is_end_requested() const { return requests_.has_end_request(); }

  /// Returns true if the next tick has an event to record or a request to carry out.
  [[nodiscard]] bool has_pending_work() const { return !events_.empty() || requests_.find_next() != nullptr; }

  /// Makes the chamber safe immediately, when the run must end without another tick. end_cause() reports whether that
  /// succeeded. The watchdog watches the air afterwards.
  void make_safe(const std::string& cause);
  /// Returns the events that no second has recorded yet, for a run that ends without another tick.
  [[nodiscard]] std::vector<Event> take_pending_events();

  /// Leaves the chamber to its controller, to which the profile was uploaded as a program. Call it before the first
  /// tick.
  void hand_over_to_controller();
  [[nodiscard]] bool is_led_by_controller() const { return lead_->can_continue_alone(); }

  /// Describes a unit that was too cold to open the door when it was last read; empty if it was warm enough, or on a
  /// virtual rig without [room].
  [[nodiscard]] std::string describe_cold_unit() const;

  /// Describes how another program or a person has changed the chamber, by the last reading; empty if unchanged.
  [[nodiscard]] std::string describe_external_change() const;

  /// Returns the reason why the chamber must not be left at its set point, by the last reading: its air is away from
  /// the set point and does not approach it. Empty if it may be left.
  [[nodiscard]] std::string leaving_refusal() const { return leaving_refusal(last_); }

  /// Sets, by subject, the reasons why the watchdog could not make the chamber safe; empty if it could. They apply from
  /// the next tick.
  void set_guard_troubles(std::map<std::string, std::string> troubles) { guard_troubles_ = std::move(troubles); }

  /// Records an event with the next tick.
  void note(EventKind kind, std::string text, EventSubject about = {});

  /// Describes the reason for the run's end, and whether the chamber is safe.
  [[nodiscard]] std::string end_cause() const;
  /// Returns true if the chamber has shown that its set point, its mode and its air are safe.
  [[nodiscard]] bool is_safe() const { return safe_.is_confirmed(); }
  [[nodiscard]] std::int64_t next_slot() const { return next_slot_; }
  [[nodiscard]] const profile::ProfileState& state() const { return state_; }
  /// Returns the profile with the blocks that were added to it so far.
  [[nodiscard]] const profile::Profile& profile() const { return profile_; }

  // A run that ends by itself (docs/self-ending-runs.md).

  /// Returns whether a decision is due: the run is in the last minutes of its last segment and has not been decided to
  /// end. Until the decision is carried out, the last hold continues.
  [[nodiscard]] bool awaits_decision() const;
  /// Records a decision and adds its block, or the closing segments, to the profile. Call it between two ticks. Fails
  /// with mismatch, and changes nothing, if the block is not released at this point, or with storage.
  [[nodiscard]] Result<void> carry_out(const record::Decision& decision);

  /// Returns the last tick's sample; an empty one before the first tick.
  [[nodiscard]] const Sample& last() const { return last_; }
  /// Returns the events that the last tick recorded, in order.
  [[nodiscard]] const std::vector<Event>& last_events() const { return last_events_; }
  [[nodiscard]] RunState run_state() const { return run::run_state(machine_); }
  [[nodiscard]] bool is_paused_by_operator() const {
    const auto* held = std::get_if<Held>(&machine_);
    return held && held->paused;
  }
  [[nodiscard]] RunOverview overview() const;

 private:
  [[nodiscard]] control::ControlAnswer drop_or_return(const control::UnitRequest& request, const std::string& who,
                                                      const std::string& why);
  /// Acknowledges the alarms of these numbers and their consequences; all alarms if there is no number.
  [[nodiscard]] control::ControlAnswer acknowledge(const std::vector<std::int64_t>& numbers, const std::string& who,
                                                   const std::string& comment);
  /// Writes to the record immediately, like an acknowledgement.
  [[nodiscard]] control::ControlAnswer shelve_or_unshelve(const control::ShelvingRequest& request,
                                                          const std::string& who, const std::string& reason);
  void note_ended_shelvings();
  struct Acknowledged {
    /// Numbers of acknowledged root alarms and of acknowledged consequences.
    std::size_t roots{}, consequences{};
    /// One per refused number.
    std::vector<std::string> refusals{};
  };
  /// Writes to the record immediately, so the next request finds the alarms acknowledged.
  [[nodiscard]] Acknowledged append_acknowledgements(const std::vector<std::int64_t>& numbers, const std::string& who,
                                                     const std::string& comment);
  Result<void> record_gap(std::int64_t slot);
  void note_changes(const Sample& sample);
  /// Reads every instrument, and compares the power supplies with the profile.
  [[nodiscard]] Sample read_rig(std::int64_t slot, Duration missed);
  void note_all(std::vector<RigChange> changes);
  [[nodiscard]] interlocks::InterlockInputs inputs(const Sample& sample, Duration missed) const;
  [[nodiscard]] interlocks::InterlockDemand judge_second(const Sample& sample, Duration missed);
  /// Collects the lead's inputs for this second, at the profile's current state.
  [[nodiscard]] LeadSecond second(const Sample& sample, Duration missed) const;
  /// Returns true if a command would take the chamber over from a foreign set point.
  [[nodiscard]] bool takes_over(control::OperatorCommand command) const;
  /// Returns the cause if the last second demands exactly this reaction; empty if it demands another reaction or none.
  [[nodiscard]] std::string active_cause(interlocks::Reaction reaction, bool takes_over) const;
  /// Returns the answer to a command without an objection. Ends with a warning if the unit is too cold to open the
  /// door.
  [[nodiscard]] std::string answer_for(control::OperatorCommand command) const;
  /// Returns the reason why the last second or the lead forbids a command; empty if they do not.
  [[nodiscard]] std::string active_refusal_reason(control::OperatorCommand command, bool takes_over) const;
  [[nodiscard]] std::optional<OperatorRequest> take_request();
  void update_safe_sequence(const Sample& sample);
  [[nodiscard]] std::string required_prompt(const Sample& sample);
  void step_machine(const Sample& sample, const interlocks::InterlockDemand& demand, Duration missed);
  void change_to(RunStateMachine machine);
  void step_profile(const Sample& sample);
  [[nodiscard]] bool must_observe_end(const Sample& sample);
  [[nodiscard]] std::string leaving_refusal(const Sample& sample) const;
  void note_following(const std::string& why);
  [[nodiscard]] profile::Observation observation(const Sample& sample) const;
  void note_soak(const ProfilePosition& before);
  void note_prolonged_hold(const ProfilePosition& before);
  void command_chamber(const Sample& sample);

  profile::Profile profile_;
  rig::Rig& rig_;
  record::Store& store_;
  profile::ProfileState state_;
  std::int64_t next_slot_;
  RunStateMachine machine_ = Execute{};
  interlocks::InterlockMemory memory_;
  std::unique_ptr<ChamberLead> lead_;
  SafeSequence safe_;
  SafeRelay relay_;
  DroppedUnits dropped_;
  const std::vector<record::Channel> channels_;
  RigChanges changes_;
  UnitPower power_;
  bool has_power_begun_ = false;
  RunTally tally_;
  /// Duration of the profile without waiting.
  Duration planned_;
  /// The last hold continues because no decision has been made in its time.
  bool is_prolonged_ = false;
  /// The seconds before this tick are missing because a command to the chamber took longer than its second.
  bool waited_for_chamber_ = false;
  /// The last second continues until the air has been observed for long enough.
  bool is_end_observed_ = false;
  std::optional<Celsius> air_;  ///< last known
  OperatorRequests requests_;
  /// Demand of the interlocks in the last second.
  interlocks::InterlockDemand demand_;
  int last_segment_ = -1;
  /// Last segment with an answered prompt.
  int answered_ = -1;
  /// Events for the next row.
  std::vector<Event> events_;
  /// Events of the last row.
  std::vector<Event> last_events_;
  std::map<std::string, std::string> guard_troubles_;
  Sample last_;
};

}  // namespace gyrotherm::run
