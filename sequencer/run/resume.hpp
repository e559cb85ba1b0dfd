// SPDX-License-Identifier: Apache-2.0
/// The data of a new record before its first sample, and the resume of an interrupted run.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/record/record.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/status.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::run {

/// Returns the data of a run from program, profile, rig and seed. The id of a dry run is derived from the data that
/// determine it (program, profile, rig, seed, day); the id of a real run is random. `days_later` is the age of a
/// virtual rig's gyro. `goal` is the goal of a run that ends by itself.
[[nodiscard]] record::RunInfo run_info(std::string_view program_version, const profile::Profile& profile,
                                       const rig::RigFile& rig, std::uint64_t seed, Duration started_utc,
                                       std::uint64_t days_later = 0,
                                       const std::optional<record::RunInfo::Goal>& goal = {});

/// Returns the description of a segment in a record.
[[nodiscard]] record::RunInfo::SegmentInfo describe_segment(const profile::Segment& segment);

/// Returns the demand on the power supplies before the first second of a new run: on, unless the first segment requires
/// the units to be off.
[[nodiscard]] drivers::PowerDemand power_at_start(const profile::Profile& profile);

/// Derives the seed of a dry run's noise from the profile.
[[nodiscard]] std::uint64_t run_number(const std::string& profile_text);

/// Adds the warm-ups of a recorded run to its profile, as parse_profile() returned it. Fails with usage if the record
/// describes an impossible one.
[[nodiscard]] Result<void> add_recorded_warm_ups(profile::Profile& profile, const record::RunInfo& info);

// The resume of an interrupted run: the rule that decides whether it may resume by itself, and how
// (docs/reliability.md), and the run's state, read from its record. Pure. The rule follows environmental testing
// (MIL-STD-810, part one, 5.2 and 5.11): an interruption on the mild side repeats the stabilisation; one outside the
// test's own extremes requires an operator's decision.

inline constexpr Duration kLongestUnattended = std::chrono::seconds(120);
inline constexpr Kelvins kResumeBand{2};
/// Longest downtime that is accepted from the wall clock; a longer one is treated as a clock error.
inline constexpr Duration kLongestBelieved = std::chrono::days(366);

/// State of a run when it was interrupted.
struct InterruptedRun {
  /// Extremes of its segment's set points.
  Celsius lowest, highest;
  /// Last known air; absent: never read.
  std::optional<Celsius> air;
  /// Time since the run's last second; one second if unknown.
  Duration down{};
  /// Reason why the downtime is unknown; empty: it is known.
  std::string why_unknown{};
  /// Reason why an operator must confirm the downtime; empty if none has to.
  std::string why_asks{};
  /// An interlock or an operator had aborted the run and made the chamber safe.
  bool aborted{};
  /// The record states how the program of the run ended.
  bool end_recorded{true};
  /// The program ended the run and released the chamber, but the record does not state how.
  bool end_lost{};
  /// The run was held; only an operator can resume it.
  bool held{};
  /// Another program or a person had changed the chamber, and it was not restored.
  bool foreign{};
  /// Person who ended the work of the guard, with the reason; empty: it was not ended.
  std::string given_up{};
  /// The chamber was found switched off, though neither the run nor its guard switches it off.
  bool found_off{};
  /// Instruments that answer in place of the run's own instruments; empty: none.
  std::string mismatched_instruments{};
};

enum class Reentry {
  /// Continue in the last state.
  go_on,
  /// Return the set point by a ramp from the actual temperature, then finish the remaining soak.
  stabilise,
  /// Only an operator resumes.
  ask,
};
struct ReentryDecision {
  Reentry way{};
  std::string why;  ///< empty for go_on
};

/// Describes each instrument whose identity differs from the one at the run's start, with both identities; empty if
/// there is none. Skips instruments that are missing in one of the maps.
[[nodiscard]] std::string compare_identities(const std::map<std::string, std::string>& at_start,
                                             const std::map<std::string, std::string>& now);

/// Applies the resume rule. `mild` is a temperature that is harmless to the unit under test. Air is acceptable from
/// `mild` to either extreme of the segment, extended by kResumeBand at both ends.
[[nodiscard]] ReentryDecision judge_reentry(const InterruptedRun& interrupted, Celsius mild, Celsius air_now);
/// Returns the reason why the downtime of a real run is unknown: by `down`, the wall clock is earlier than the run's
/// last second, or more than a year later. Empty if the downtime is known.
[[nodiscard]] std::string unknown_downtime_reason(Duration down);
/// Returns "2 min 08 s", or a text that the downtime is unknown.
[[nodiscard]] std::string describe_downtime(const InterruptedRun& interrupted);

/// Returns true if the air is within kResumeBand of the goal or of `air_before`.
[[nodiscard]] bool is_in_place(Celsius air, Celsius goal, const std::optional<Celsius>& air_before);

/// The first set point of a resumed run, chosen to avoid a jump of the chamber's temperature.
struct EntryPoint {
  Celsius set_point;
  /// The set point is the air's temperature, away from the profile. The run returns by a ramp.
  bool away{};
  /// The set point is the air's temperature, and reaches the profile by a ramp while the profile's clock runs.
  bool behind{};
};
[[nodiscard]] EntryPoint entry_at(Celsius goal, Celsius air_now, bool air_in_place,
                                  const profile::ChamberLimits& limits);

/// Clock of the profile while the set point ramps from the air temperature.
enum class EntryClock {
  waits,  ///< a new run
  /// A resumed run continues at once if the air is within kResumeBand of the goal.
  runs,
};

/// Replaces an entry whose set point would be a step by one that starts at the air temperature (decision 0084). The set
/// point is a step if both the air and the set point that a running chamber shows differ from it by more than the
/// permitted ramp rate allows in a second, or by more than 0.1 K if that is more.
[[nodiscard]] EntryPoint avoid_step(const EntryPoint& entry, const ChamberState& found,
                                    const profile::ChamberLimits& limits, EntryClock clock);

/// The extremes of the set points of one segment.
struct SegmentExtremes {
  Celsius lowest, highest;
};
[[nodiscard]] SegmentExtremes segment_extremes(const profile::Profile& profile, const profile::ProfileState& state);

struct RunContinuation {
  rig::RigFile rig;
  profile::Profile profile;
  /// State in the first second after the gap. The profile's clock does not run in the gap.
  profile::ProfileState state;
  /// Last slot with a sample; −1 if there is none.
  std::int64_t last_slot{};
  /// Last slot with a sample or in a gap; −1 if there is none.
  std::int64_t recorded{};
  InterruptedRun interruption;
  std::string why_stopped;  ///< as text
  /// Start parameters of the rig.
  rig::RigStart start{};
};

/// The clocks of the machine at one moment.
struct MachineTime {
  Duration utc{};         ///< since 1970
  Duration since_boot{};  ///< sleep included
  /// Id of the machine's start.
  std::string boot;
};

struct Downtime {
  Downtime(Duration since_last, std::string why = {}) : down(since_last), why_asks(std::move(why)) {}
  /// Time since the last recorded second.
  Duration down{};
  /// Reason why an operator must confirm the downtime; empty if none has to.
  std::string why_asks;
};

/// Returns the downtime of a real run. If `status`, the file next to the record, belongs to this run and to the current
/// boot of the machine, uses the boot clock, which cannot be set. Otherwise uses the wall clock and requires an
/// operator.
[[nodiscard]] Downtime compute_downtime(const record::Record& record, const std::optional<record::RunStatus>& status,
                                        const MachineTime& now);

/// Prepares the continuation of a run. `downtime` is the time since the last recorded second. A virtual rig is down for
/// at least one second. The downtime of a real run is unknown if it is negative, or a year or more. `run` is the number
/// that seeds the noise of a virtual rig's run. Relative paths of commands are resolved in the folder of the rig file
/// that the record names. Fails with usage (finished, imported) or bad_file (the record's own texts cannot be parsed).
[[nodiscard]] Result<RunContinuation> plan_continuation(const record::Record& record, const std::string& path,
                                                        const Downtime& downtime, std::uint64_t run);

}  // namespace gyrotherm::run
