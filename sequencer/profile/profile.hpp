// SPDX-License-Identifier: Apache-2.0
/// The plan of an experiment: a TOML file, checked and expanded into a flat list of holds and ramps before anything
/// moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::profile {

enum class SegmentKind { hold, ramp };

/// One step of the expanded profile. A ramp moves the set point from the previous segment's target to its own in a
/// straight line over `duration`; a hold keeps it there for `duration`.
struct Segment {
  SegmentKind kind{};
  std::string name;
  Celsius target;
  CelsiusPerMinute rate{};          ///< magnitude; 0 for a hold
  Duration duration{};              ///< whole seconds, by set point
  bool guaranteed_soak{};           ///< the hold's time counts only while the air is inside the band
  Kelvins soak_band{};              ///< |sensor − set point| that counts as soaked
  std::string soak_sensor = "air";  ///< the chamber's air, or a thermometer's channel
  Duration soak_dwell{};            ///< how long the sensor must be inside the band before the soak counts
  CelsiusPerMinute soak_slope{};    ///< the fastest that the sensor may move over a minute then; 0: however fast
  Duration
      soak_time{};  ///< with a guaranteed soak: how long must be spent inside the band (default: the hold's duration)
  Duration deadline{};     ///< longest time the segment may take, waiting included
  std::string prompt{};    ///< what people are asked to do before it begins: the run waits for them; empty: nothing
  UnitState unit{};        ///< how the unit under test is in it
  int cycle{-1};           ///< index into Profile::cycles, or -1
  std::string unheeded{};  ///< keys of a soak that stand on it though it is none, in words; empty: none do
  std::string place{};     ///< "file:line:column" it was written at
};

/// The time a segment takes if its soak counts from the first second: a guaranteed soak is never shorter than the
/// hold's duration, and counts only after its dwell.
[[nodiscard]] Duration shortest(const Segment& segment);

/// Limits of the profile's `[accept]` table; a result beyond one is exit code 1. Absent keys accept anything.
struct AcceptLimit {
  std::string key;  ///< a path of the report, like "random.multi_point_t.std_deg_per_h"
  double at_most{};
};

struct Profile {
  std::string name;
  std::string title;
  std::map<std::string, std::string> metadata;
  std::vector<std::string> cycles;  ///< names, in order
  std::vector<Segment> segments;
  std::vector<AcceptLimit> accept;
  std::string text;  ///< the file, as read
};

/// The set point that a segment starts from: the target of the one before it, or its own if it is the first.
[[nodiscard]] Celsius set_point_before(const Profile& profile, std::size_t segment);

/// Reads and expands. Fails with bad_file, every mistake with its place (empty repeat, zero or negative times, unknown
/// keys, a hold or ramp without what it needs, more than 20,000 segments …).
[[nodiscard]] Result<Profile> parse_profile(std::string_view text, const std::string& file);

/// What a chamber can do; from the rig file.
struct ChamberLimits {
  Celsius lowest{-273.15};
  Celsius highest{1000};
  CelsiusPerMinute fastest_heating{1000};
  CelsiusPerMinute fastest_cooling{1000};  ///< magnitude
};

/// Refuses what the chamber cannot do (temperatures and rates beyond it, deadlines shorter than the segment), and what
/// the profile would not do as it says (a hold at another temperature that nothing leads to or waits for, keys of a
/// soak where there is none); every mistake with the place of its segment.
[[nodiscard]] Result<void> check_profile(const Profile& profile, const ChamberLimits& limits);

/// Refuses what would end the run by the limits of the chamber's air, with the place of its segment.
[[nodiscard]] Result<void> check_air(const Profile& profile, Celsius lowest, Celsius highest);

/// Refuses a soak on a sensor that is neither "air" nor one of `channels`, with the place of its segment.
[[nodiscard]] Result<void> check_sensors(const Profile& profile, const std::vector<std::string>& channels);

/// Refuses to turn the unit where the rig cannot, with the place of the segment.
[[nodiscard]] Result<void> check_turns(const Profile& profile, bool can_turn);

// The profile laid out in time, as it would run if every soak counted from its first second.

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

[[nodiscard]] Timeline plan(const Profile& profile);

/// The table that `gyrotherm check` prints: each segment with start, duration, from, to, rate; then per cycle and in
/// all, and what people will be asked to do.
[[nodiscard]] std::string describe(const Profile& profile, const Timeline& timeline);

}  // namespace gyrotherm::profile
