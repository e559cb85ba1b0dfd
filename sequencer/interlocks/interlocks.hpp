// SPDX-License-Identifier: Apache-2.0
/// The conditions under which a run may continue. judge() evaluates one second against the limits. Its result overrides
/// the profile. Pure; any thread.
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/sample.hpp"
#include "sequencer/interlocks/interlock_memory.hpp"
#include "sequencer/interlocks/limits.hpp"

namespace gyrotherm::interlocks {

/// A cause at a power supply of the units under test.
struct PowerFault {
  /// "supply 1, output 2".
  std::string subject;
  std::string text;
};

/// The state of the power supplies in one second, compared with the state that the profile requires.
struct PowerFaults {
  /// Voltages and currents outside the limits of the rig file.
  std::vector<PowerFault> outside{};
  /// Outputs whose protection has tripped.
  std::vector<PowerFault> tripped{};
  /// Outputs that this program did not switch on or off.
  std::vector<PowerFault> changed{};
  /// Switches that are demanded and not verified yet.
  std::vector<PowerFault> not_switched{};
  /// Subjects that were not read.
  std::vector<std::string> unread{};
};

/// Facts about a second that its sample does not contain.
struct InterlockInputs {
  /// Set point that the chamber last accepted; nothing if it is unknown.
  std::optional<Celsius> sent{};
  /// Largest difference between a set point and the controller's rounded value.
  Kelvins set_point_tolerance{0.1};
  /// Number of consecutive set points that the chamber refused.
  int refusals{};
  /// Reason for the latest refusal of a set point.
  std::string refusal{};
  /// The last set point was refused and will be sent again. Until then the chamber may show any value.
  bool sends_again{};
  /// Fault of the program that runs in the chamber's controller; empty: no fault.
  std::string program{};
  /// The controller computes the set points itself.
  bool led_by_controller{};
  /// Time without ticks immediately before this second.
  Duration missed{};
  Duration longest_missed = std::chrono::seconds(120);
  /// Time by which the record lags behind the run.
  Duration backlog{};
  bool rows_dropped{};
  /// Reason why the disk accepts no rows.
  std::string storage_trouble{};
  /// Damage to the record's files by another program.
  std::string record_damage{};
  /// Reasons why the watchdog could not make the chamber safe if this program ended, by subject ("guard", "safe-state
  /// file").
  std::map<std::string, std::string> guard_troubles{};
  /// Descriptions of instruments that answer in place of the expected ones.
  std::vector<std::string> mismatched_instruments{};
  /// The profile requires the units to be off, or the operator may not have switched them on yet. Their silence is not
  /// a fault.
  bool gyro_is_off{};
  /// An operator may be turning the units.
  bool units_are_moved{};
  /// The run waits for operators or has been aborted, so that they may open the door.
  bool door_may_open{};
  bool is_turned{};  ///< input axes reversed
  PowerFaults power{};
  /// Units under test that an operator has dropped; empty: none.
  std::vector<bool> dropped{};
};

/// The fault that one check found in one subject.
struct CheckResult {
  std::string text;
  /// The fault ends the run regardless of the policy.
  bool grave = false;
  /// Thermometer that shows the fault.
  std::optional<std::size_t> column = {};
  /// Name of a channel, unit or instrument; may be empty.
  std::string subject = {};
  /// Upper limit of the reaction, even if the policy is more severe.
  Reaction at_most = Reaction::abort;
  /// Replaces the time for which the cause must be present.
  std::optional<Duration> after = {};
  /// Follows the text and the time for which the cause was present.
  std::string detail = {};
};

struct CheckInputs;

/// How long a cause must be present before the interlock acts, given as values or as members of InterlockLimits. The
/// cause must be present in `samples` of the last 2 × `samples` samples, and for a total of `after` within the last 2 ×
/// `after`. With `in_a_row`, it must instead be present for `after` without a break.
struct Confirmation {
  Duration after{};
  Duration InterlockLimits::*after_limit = nullptr;
  int samples = 1;
  int InterlockLimits::*samples_limit = nullptr;
  bool in_a_row = false;
};

/// One row of the table of interlocks.
struct Interlock {
  InterlockId id{};
  /// Keyword in [policy] and the record.
  const char* name = "";
  Reaction usual{};  ///< reaction without an entry in [policy]
  /// [policy] may set the reaction. False if another reaction could damage the unit under test.
  bool choosable = true;
  Confirmation confirmation{};
  /// Duration of silence after which the run is aborted.
  Duration InterlockLimits::*lost_after = nullptr;
  /// The cause is permanent: after the second in which it was found, the interlock only warns.
  bool is_never_over = false;
  /// Keys of [limits] that the check uses, separated by blanks.
  std::string_view limits{};
  /// Looks for the cause in one second. Returns one result for each affected subject.
  std::vector<CheckResult> (&check)(const CheckInputs&);
  /// Returns true if the quantity that shows the cause was not read in this second. Null: it is always read.
  bool (*unread)(const CheckInputs&, const InterlockMemory::Watch&) = nullptr;
};
[[nodiscard]] const Interlock& interlock(InterlockId id);
[[nodiscard]] inline const char* name(InterlockId id) { return interlock(id).name; }

/// The demand of the interlocks on the run.
struct InterlockDemand {
  Reaction reaction = Reaction::go_on;
  std::string cause;  ///< empty: no demand
};

/// An alarm, identified by its interlock and its subject.
struct InterlockAlarm {
  InterlockId id{};
  Reaction reaction{};
  std::string text;
  /// Name of a channel, unit or instrument; may be empty.
  std::string subject{};
};

struct InterlockResult {
  InterlockDemand demand;
  InterlockMemory memory;
  std::vector<InterlockAlarm> raised;   ///< in this second
  std::vector<InterlockAlarm> cleared;  ///< in this second
};

/// Checks one sample, which covers `elapsed`, against every interlock. The most severe reaction wins.
[[nodiscard]] InterlockResult judge(const InterlockLimits& limits, InterlockMemory memory, const Sample& sample,
                                    Duration elapsed, const InterlockInputs& inputs = {});

/// Returns the demand of the last sample, ignoring the interlocks in `some`.
[[nodiscard]] InterlockDemand demand_without(const InterlockMemory& memory, const std::vector<InterlockId>& some);

/// Returns the active causes that an operator's resume clears by taking the chamber over: a foreign set point, a mode
/// that does not follow the set point, and a restart of the chamber if it holds the run. A resume also switches the
/// power supplies again, which ends a trip, and the change of an output by another program or a person.
[[nodiscard]] std::vector<InterlockId> causes_ended_by_resume(const InterlockMemory& memory);

/// Returns the reason why the chamber must not be left at its set point: it was restarted, or refuses set points; its
/// air is away from the set point and does not approach it; or it gave no reading for 2 s. Changes by other programs
/// are judged elsewhere. Returns an empty text if the chamber may be left.
[[nodiscard]] std::string leaving_refusal(const InterlockLimits& limits, const InterlockMemory& memory,
                                          const Sample& sample);

/// Describes a unit that is too cold for the air that would enter through the door: its coldest thermometer, and the
/// temperature to wait for. Empty if the unit is warm enough, or without limits.room.
[[nodiscard]] std::string describe_cold_unit(const InterlockLimits& limits, const Sample& sample);

/// Returns the coldest reading of the units' thermometers, and its column. Ignores the thermometers in the air, unless
/// there are no others. Returns nothing if none was read.
struct ColdestReading {
  Celsius value;
  std::size_t column{};
};
[[nodiscard]] std::optional<ColdestReading> find_coldest(const InterlockLimits& limits, const Sample& sample);

/// Returns whether a cause concerns the power supplies.
[[nodiscard]] bool is_about_power(InterlockId id);

/// Returns one line for each active alarm.
[[nodiscard]] std::vector<std::string> active_faults(const InterlockMemory& memory);

}  // namespace gyrotherm::interlocks
