// SPDX-License-Identifier: Apache-2.0
/// The plan of an experiment. parse_profile() reads a TOML file and expands it into a flat list of holds and ramps; the
/// check functions compare it with the rig before anything moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::profile {

enum class SegmentKind { hold, ramp };

/// One step of the expanded profile. A ramp moves the set point in a straight line over `duration`, from the previous
/// segment's target to its own. A hold keeps the set point for `duration`.
struct Segment {
  SegmentKind kind{};
  std::string name;
  Celsius target;
  /// Magnitude; 0 for a hold.
  CelsiusPerMinute rate{};
  /// Duration of the set point's movement or hold, in whole seconds.
  Duration duration{};
  /// The hold's time counts only while the soak sensor is inside the band.
  bool guaranteed_soak{};
  /// Largest |sensor − set point| inside the band.
  Kelvins soak_band{};
  /// Air, or a thermometer's channel.
  std::string soak_sensor = "air";
  /// Time that the sensor must be inside the band before the soak counts.
  Duration soak_dwell{};
  /// Largest change of the sensor over a minute while the soak counts; 0: no limit.
  CelsiusPerMinute soak_slope{};
  /// Time that a guaranteed soak requires inside the band. The default is the duration of the hold.
  Duration soak_time{};
  /// Longest duration, waiting included.
  Duration deadline{};
  /// Task for the operator before the segment begins. The run waits for the confirmation; empty: no task.
  std::string prompt{};
  /// The prompt was written in the profile. Otherwise it describes the change of the unit's state.
  bool has_own_prompt{};
  /// Required state of the unit.
  UnitState unit{};
  /// Index into Profile::cycles, or -1.
  int cycle{-1};
  /// Soak keys of a segment without a guaranteed soak, as text; empty: none.
  std::string ignored_keys{};
  std::string place{};  ///< "file:line:column" in the profile
  /// The operators open the chamber's door when they are prompted.
  bool opens_door{};
  /// A hold that a run adds: its soak counts while the coldest thermometer is at or above `target` − `soak_band`.
  bool is_warm_up{};
};

/// Sensor of a warm-up: the coldest thermometer of the units.
inline constexpr const char* kColdestThermometer = "coldest thermometer";

/// Parameters of the warm-ups that a run adds to a profile (warm_up.hpp).
struct WarmUp {
  Celsius at_least;  ///< the unit's lowest temperature
  Celsius air;
  CelsiusPerMinute rate{};
};

/// Returns the duration of a segment whose soak counts from the first second, which is the shortest possible one. It
/// includes the dwell of a guaranteed soak and is never shorter than the hold.
[[nodiscard]] Duration shortest(const Segment& segment);

/// A limit in the profile's `[accept]` table. A result above the limit leads to exit code 1. Results without a limit
/// are accepted.
struct AcceptLimit {
  /// A path of the report, such as "random.multi_point_t.std_deg_per_h".
  std::string key;
  double at_most{};
};

/// Segments that a run may add at the end of its profile, expanded and checked for each set point at which they can
/// begin.
struct ReleasedBlock {
  /// Empty: the closing segments.
  std::string name;
  std::string place;  ///< "file:line:column" in the profile
  struct Expanded {
    Celsius from;
    std::vector<Segment> segments;
  };
  std::vector<Expanded> expanded;
};

/// The table `[until]` of a profile whose run ends by itself (released_blocks.hpp). The segments of the profile are its
/// fixed opening.
struct Until {
  double u_deg_per_h{};
  std::string mission;
  std::string prior{};  ///< empty: none
  /// Longest duration of the run, opening and closing included.
  Duration longest{};
  std::string place;  ///< "file:line:column" in the profile
  std::vector<ReleasedBlock> blocks;
  /// Always carried out at the end; may have no segments.
  ReleasedBlock closing;
};

struct Profile {
  std::string name;
  std::string title;
  std::map<std::string, std::string> metadata;
  std::vector<std::string> cycles;  ///< names
  std::vector<Segment> segments;
  std::vector<AcceptLimit> accept;
  /// The run may add warm-ups.
  bool warms_up = true;
  std::optional<WarmUp> warm_up{};  ///< present if `segments` or a released block contains one
  std::optional<Until> until{};
  /// Names of the blocks that were added to `segments`, in order. The closing segments have an empty name.
  std::vector<std::string> added_blocks{};
  /// Text of the file.
  std::string text;
};

/// Returns the set point at the start of a segment: the target of the previous segment, or its own target if it is the
/// first.
[[nodiscard]] Celsius set_point_before(const Profile& profile, std::size_t segment);

/// Reads a profile and expands it. Fails with bad_file and lists every error with its position (empty repeat, zero or
/// negative times, unknown keys, a hold or ramp with missing keys, more than 20,000 segments …).
[[nodiscard]] Result<Profile> parse_profile(std::string_view text, const std::string& file);

/// Limits of a chamber, from the rig file.
struct ChamberLimits {
  Celsius lowest{-273.15};
  Celsius highest{1000};
  CelsiusPerMinute fastest_heating{1000};
  CelsiusPerMinute fastest_cooling{1000};  ///< magnitude
};

/// Fails if the chamber cannot carry out the profile (temperatures or rates outside its limits, deadlines shorter than
/// the segment), or if the profile contradicts itself (a hold at a temperature that no ramp leads to and no soak waits
/// for, soak keys without a guaranteed soak). Lists every error with the position of its segment.
[[nodiscard]] Result<void> check_profile(const Profile& profile, const ChamberLimits& limits);

/// Fails if the target of a segment is outside limits at which a run ends: those of the "air" or of the "thermometer".
/// Lists the position of each such segment.
[[nodiscard]] Result<void> check_run_limits(const Profile& profile, const char* which, Celsius lowest, Celsius highest);

/// Fails if a segment soaks on a sensor that is neither "air" nor one of `channels`. Lists the position of each such
/// segment.
[[nodiscard]] Result<void> check_sensors(const Profile& profile, const std::vector<std::string>& channels);

/// Returns the profile for a rig whose power supplies switch the units: no prompt asks a person to switch a unit,
/// except the units in `unfed`. A prompt that was written in the profile stays.
[[nodiscard]] Profile switch_by_supplies(Profile profile, const std::vector<std::string>& unfed);

/// Describes the operator's task for changing the state of the unit; empty if the state does not change. `units` are
/// the units to be switched if they are not all.
[[nodiscard]] std::string describe_change(const UnitState& from, const UnitState& to,
                                          const std::vector<std::string>& units = {});

/// Fails if a segment turns the unit around and no unit of the rig can be turned. Lists the position of each such
/// segment.
[[nodiscard]] Result<void> check_turns(const Profile& profile, bool can_turn);

// The timeline of a profile if every soak counts from its first second.

struct PlannedSegment {
  Duration start{};
  Duration duration{};
  Celsius from;
  Celsius to;
};

struct CycleTotal {
  std::string name;
  Duration ramps{};
  Duration holds{};
  std::int64_t clusters{};  ///< whole 100-s clusters
};

struct Timeline {
  std::vector<PlannedSegment> segments;  ///< one per Profile::segments
  std::vector<CycleTotal> cycles;        ///< one per Profile::cycles
  CycleTotal all;
};

/// Computes the timeline of a profile.
[[nodiscard]] Timeline plan(const Profile& profile);

/// Returns the table that `gyrotherm check` prints: each segment with start, duration, from, to and rate, the totals of
/// each cycle and of the profile, and the tasks for the operator.
[[nodiscard]] std::string describe(const Profile& profile, const Timeline& timeline);

}  // namespace gyrotherm::profile
