// SPDX-License-Identifier: Apache-2.0
/// The conditions under which a run may go on. Pure: limits, what was seen, and what is remembered go in, a result
/// comes out; it outranks the profile. Any thread.
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

/// What the rig knows beside the sample.
struct InterlockInputs {
  std::optional<Celsius> sent{};     ///< the set point that the chamber last took; nothing: it is not known
  Kelvins set_point_tolerance{0.1};  ///< what the controller may make of it
  int refusals{};                    ///< set points in a row that it did not take
  std::string refusal{};             ///< why
  bool sends_again{};                ///< the last of them just now: the chamber may show anything until the next
  std::string program{};             ///< what is wrong with a program that the controller carries out
  bool led_by_controller{};          ///< set points are the controller's own
  Duration missed{};                 ///< time without ticks just before this one
  Duration longest_missed = std::chrono::seconds(120);
  Duration backlog{};  ///< how far the record is behind
  bool rows_dropped{};
  std::string storage_trouble{};  ///< why the disk takes no rows
  std::string record_damage{};    ///< what another program did to the record's files
  /// By subject ("guard", "safe-state file"): why the chamber would not be made safe if this program ended.
  std::map<std::string, std::string> guard_troubles{};
  std::vector<std::string> strangers{};  ///< instruments that answer in place of others
  bool gyro_is_off{};                    ///< by the profile's own wish, so that its silence is no fault
  bool units_are_moved{};                ///< people may be turning them
  bool is_turned{};                      ///< input axes point the other way
  std::vector<bool> dropped{};           ///< units under test that an operator has dropped; empty: none
};

/// Describes what one check found wrong with one subject.
struct CheckResult {
  std::string text;
  bool grave = false;                      ///< ends the run whatever the policy is
  std::optional<std::size_t> column = {};  ///< which thermometer shows it
  std::string subject = {};                ///< channel, unit, instrument; may be empty
  Reaction at_most = Reaction::abort;      ///< however severe the policy is
};

struct CheckInputs;

/// Gives, as a number or a key of [limits], for how long and in how many samples a cause must be there before its
/// interlock acts: within the last 2 × `samples` samples and the last 2 × `after`, or, if `in_a_row`, without a break.
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
  const char* name = "";  ///< as [policy] and the record spell it
  Reaction usual{};       ///< unless the rig file's [policy] says otherwise
  bool choosable = true;  ///< [policy] may say otherwise: not for what would damage the unit under test
  Confirmation confirmation{};
  Duration InterlockLimits::*lost_after = nullptr;  ///< a silence of this length ends the run
  bool is_never_over = false;  ///< what is done stays done: more than a warning is asked for while it is news
  std::string_view limits{};   ///< the keys of [limits] that it heeds, between blanks
  /// Looks for the cause in one second. Returns one result for each subject that has it.
  std::vector<CheckResult> (&check)(const CheckInputs&);
  /// Returns true if what would show the cause, or its end, was not read in this second; null: it always is read.
  bool (*unread)(const CheckInputs&, const InterlockMemory::Watch&) = nullptr;
};
[[nodiscard]] const Interlock& interlock(InterlockId id);
[[nodiscard]] inline const char* name(InterlockId id) { return interlock(id).name; }

/// What an interlock demands of the run.
struct InterlockDemand {
  Reaction reaction = Reaction::go_on;
  std::string cause;  ///< empty when nothing is wrong
};

/// An alarm is identified by its interlock and its subject.
struct InterlockAlarm {
  InterlockId id{};
  Reaction reaction{};
  std::string text;
  std::string subject{};  ///< channel, unit, instrument; may be empty
};

struct InterlockResult {
  InterlockDemand demand;
  InterlockMemory memory;
  std::vector<InterlockAlarm> raised;   ///< with this sample: one per interlock and subject
  std::vector<InterlockAlarm> cleared;  ///< with this sample
};

/// Judges one sample that covers `elapsed`. The most severe reaction wins.
[[nodiscard]] InterlockResult judge(const InterlockLimits& limits, InterlockMemory memory, const Sample& sample,
                                    Duration elapsed, const InterlockInputs& inputs = {});

/// Returns the demand of all interlocks but these, with the last sample that was judged.
[[nodiscard]] InterlockDemand demand_beside(const InterlockMemory& memory, const std::vector<InterlockId>& some);

/// The causes that an operator's resume ends by taking the chamber over: a foreign set point, a mode that
/// does not follow it, and a restart that holds.
[[nodiscard]] std::vector<InterlockId> taken_over_by_resume(const InterlockMemory& memory);

/// One line for each alarm that stands.
[[nodiscard]] std::vector<std::string> standing_faults(const InterlockMemory& memory);

}  // namespace gyrotherm::interlocks
