// SPDX-License-Identifier: Apache-2.0
/// What a new record knows before its first sample, from the program, the profile, the rig and the seed.
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

/// The id of a dry run is derived from what determines it (program, profile, rig, seed, day); that of a real run is
/// drawn. `days_later`: of a virtual rig.
[[nodiscard]] record::RunInfo run_info(std::string_view program_version, const profile::Profile& profile,
                                       const rig::RigFile& rig, std::uint64_t seed, Duration started_utc,
                                       std::uint64_t days_later = 0);

/// A number of the profile's own: what draws the noise of a dry run of it.
[[nodiscard]] std::uint64_t run_number(const std::string& profile_text);

// How an interrupted run goes on: the resume rule, which says whether it may by itself, and how (docs/reliability.md),
// and where the run stood, out of its record. Pure. The rule's
// practice is that of environmental testing (MIL-STD-810, part one, 5.2 and 5.11): an interruption on the mild side
// repeats the stabilisation, one that went beyond the test's own extremes is for people to judge.

inline constexpr Duration kLongestUnattended = std::chrono::seconds(120);
inline constexpr Kelvins kResumeBand{2};
/// A clock on the wall that says more than this is taken for wrong; a record holds three years.
inline constexpr Duration kLongestBelieved = std::chrono::days(366);

/// How a run stood when its ticks ended.
struct InterruptedRun {
  Celsius lowest, highest;     ///< the extremes of its segment's set points
  std::optional<Celsius> air;  ///< last known; nothing: never seen
  Duration down{};             ///< since its last second; one second where nobody knows
  std::string why_unknown{};   ///< why nobody knows how long it was down; empty: it is known
  std::string why_asks{};      ///< why an operator must judge `down`
  bool aborted{};              ///< an interlock, or an operator, had ended it and made the chamber safe
  bool held{};                 ///< it was held: only an operator goes on
  bool foreign{};              ///< somebody else had changed the chamber, and it was not put back
  std::string strangers{};     ///< instruments that answer in place of the run's; empty: none
};

enum class Reentry {
  go_on,      ///< where it stood
  stabilise,  ///< the set point goes back by a ramp from the actual temperature, then the remaining soak is finished
  ask,        ///< only an operator goes on
};
struct ReentryDecision {
  Reentry way{};
  std::string why;  ///< empty when it just goes on
};

/// Describes each instrument that reports to be another than when the run began, with both identities; empty where none
/// does. An instrument that one of the two does not know is not compared.
[[nodiscard]] std::string strangers_among(const std::map<std::string, std::string>& at_start,
                                          const std::map<std::string, std::string>& now);

/// `mild`: the temperature that is harmless to the article; what lies between it and the segment's own extremes, and
/// within the band beyond, is the mild side.
[[nodiscard]] ReentryDecision judge_reentry(const InterruptedRun& stood, Celsius mild, Celsius air_now);
/// Why nobody knows how long a real run was down, of which the clock on the wall says `down`: it lies before the last
/// second, or a year behind it. Empty: it is known.
[[nodiscard]] std::string why_down_is_unknown(Duration down);
/// "2 min 08 s", or that nobody knows.
[[nodiscard]] std::string down_in_words(const InterruptedRun& stood);

/// The air is where the profile needs it, or where it was.
[[nodiscard]] bool is_in_place(Celsius air, Celsius goal, const std::optional<Celsius>& air_before);

/// What the chamber is sent first, so that nothing jumps.
struct EntryPoint {
  Celsius set_point;
  bool away{};  ///< where the air is, and not the profile's: it goes back from there by a ramp
};
[[nodiscard]] EntryPoint entry_at(Celsius goal, Celsius air_now, bool air_in_place,
                                  const profile::ChamberLimits& limits);

/// The extremes of the set points of the segment that a state stands in.
struct SegmentExtremes {
  Celsius lowest, highest;
};
[[nodiscard]] SegmentExtremes extremes_of(const profile::Profile& profile, const profile::ProfileState& state);

struct RunContinuation {
  rig::RigFile rig;
  profile::Profile profile;
  profile::ProfileState state;  ///< in the first second after the gap; the profile's clock stands still in the gap
  std::int64_t last_slot{};     ///< that has a sample; −1: none
  std::int64_t recorded{};      ///< the last that has a sample or lies in a gap; −1: none
  InterruptedRun stood;
  std::string why_stopped;  ///< in words
  rig::RigStart start{};    ///< what the rig is assembled with
};

/// The clocks of the machine at one moment.
struct MachineTime {
  Duration utc{};         ///< since 1970
  Duration since_boot{};  ///< sleep included
  std::string boot;       ///< id of the machine's start
};

struct Downtime {
  Downtime(Duration since_last, std::string why = {}) : down(since_last), why_asks(std::move(why)) {}
  Duration down{};       ///< since the last recorded second
  std::string why_asks;  ///< why an operator must judge it
};

/// Returns how long a real run was down. If `status`, the file beside the record, is of this run and of this start of
/// the machine, the boot clock decides, which cannot be set. Otherwise the wall clock does, and an operator is asked.
[[nodiscard]] Downtime downtime_of(const record::Record& record, const std::optional<record::RunStatus>& status,
                                   const MachineTime& now);

/// `downtime`: since the last recorded second; a virtual rig was down for a second at least. If it is
/// negative, or a year or more, the downtime of a real run is unknown. `run`: the number that draws the noise of a
/// virtual rig's run. Relative paths of commands are resolved in the folder of the rig file that the record names.
/// Fails with usage (finished, imported) or bad_file (the record's own texts cannot be read any more).
[[nodiscard]] Result<RunContinuation> continuation_of(const record::Record& record, const std::string& path,
                                                      const Downtime& downtime, std::uint64_t run);

}  // namespace gyrotherm::run
