/// The resume rule: whether a run that was interrupted may go on by itself, and how (docs/reliability.md). Pure. The
/// practice is that of environmental testing (MIL-STD-810, part one, 5.2 and 5.11): an interruption on the mild side
/// repeats the stabilisation, one that went beyond the test's own extremes is for people to judge.
#pragma once

#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm {

inline constexpr Duration kLongestUnattended = std::chrono::seconds(120);
inline constexpr Kelvins kResumeBand{2};

/// How a run stood when its ticks ended.
struct InterruptedRun {
  Celsius lowest, highest;     ///< of the set points of its segment
  std::optional<Celsius> air;  ///< last known; nothing: never seen
  Duration down{};             ///< since its last second
  bool aborted{};              ///< an interlock had ended it
  bool held{};                 ///< it was held: only an operator goes on
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

/// `mild`: the temperature that is harmless to the article; what lies between it and the segment's own extremes, and
/// within the band beyond, is the mild side.
[[nodiscard]] ReentryDecision judge_reentry(const InterruptedRun& stood, Celsius mild, Celsius air_now);

/// The air is where the profile needs it, or where it was.
[[nodiscard]] bool is_in_place(Celsius air, Celsius goal, const std::optional<Celsius>& air_before);

/// What the chamber is sent first, so that nothing jumps.
struct EntryPoint {
  Celsius set_point;
  bool away{};  ///< where the air is, and not the profile's: it goes back from there by a ramp
};
[[nodiscard]] EntryPoint entry_at(Celsius goal, Celsius air_now, bool air_in_place, const ChamberLimits& limits);

/// The extremes of the set points of the segment that a state stands in.
struct SegmentExtremes {
  Celsius lowest, highest;
};
[[nodiscard]] SegmentExtremes extremes_of(const Profile& profile, const ProfileState& state);

}  // namespace gyrotherm
