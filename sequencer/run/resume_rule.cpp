#include "sequencer/run/resume_rule.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gyrotherm {

ReentryDecision judge_reentry(const InterruptedRun& stood, Celsius mild, Celsius air_now) {
  if (stood.aborted) return {Reentry::ask, "an interlock ended this run"};
  if (stood.held) return {Reentry::ask, "the run was held"};
  if (stood.down > kLongestUnattended)
    return {Reentry::ask, fmt::format("down for {}, longer than {}", spoken(stood.down), spoken(kLongestUnattended))};
  const auto lowest = std::min(stood.lowest, mild) - kResumeBand;
  const auto highest = std::max(stood.highest, mild) + kResumeBand;
  if (air_now < lowest || air_now > highest)
    return {Reentry::ask, fmt::format("the air is at {:.2f} °C, beyond the segment's {:g} … {:g} °C", air_now.value,
                                      stood.lowest.value, stood.highest.value)};
  if (!stood.air) return {Reentry::stabilise, fmt::format("the air is at {:.2f} °C, it was not known", air_now.value)};
  if (abs(air_now - *stood.air) > kResumeBand)
    return {Reentry::stabilise,
            fmt::format("the air is at {:.2f} °C, it was at {:.2f} °C", air_now.value, stood.air->value)};
  return {};
}

bool is_in_place(Celsius air, Celsius goal, const std::optional<Celsius>& air_before) {
  return abs(air - goal) <= kResumeBand || (air_before && abs(air - *air_before) <= kResumeBand);
}

EntryPoint entry_at(Celsius goal, Celsius air_now, bool air_in_place, const ChamberLimits& limits) {
  if (air_in_place) return {goal, false};
  return {std::clamp(air_now, limits.lowest, limits.highest), true};
}

SegmentExtremes extremes_of(const Profile& profile, const ProfileState& state) {
  const auto index = static_cast<std::size_t>(position_of(profile, state).segment);
  const auto& segment = profile.segments[index];
  const auto from = segment.kind == SegmentKind::ramp ? set_point_before(profile, index) : segment.target;
  return {std::min(from, segment.target), std::max(from, segment.target)};
}

}  // namespace gyrotherm
