// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/warm_up.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>
#include <vector>

namespace gyrotherm::profile {
namespace {

constexpr Celsius kLeastAir{25};
constexpr Kelvins kAbove{5};
constexpr CelsiusPerMinute kGentle{2};
/// Time for which the coldest thermometer must be warm enough.
constexpr Duration kWarmTime = std::chrono::minutes(1);
constexpr Duration kLongestWait = std::chrono::hours(12);

/// Returns a ramp of whole minutes, so that controllers can store it, at no more than the rate.
Segment make_ramp(Celsius from, Celsius to, CelsiusPerMinute rate, std::string name) {
  const Duration whole_minutes = std::chrono::ceil<std::chrono::minutes>(abs(to - from) / rate);
  const auto time = std::max<Duration>(std::chrono::minutes(1), whole_minutes);
  return {.kind = SegmentKind::ramp,
          .name = std::move(name),
          .target = to,
          .rate = {60.0 * abs(to - from).value / to_seconds(time)},
          .duration = time,
          .deadline = time};
}

/// Appends the ramp and the hold of a warm-up that begins at the set point `from`, in the state and cycle of `like`.
void append_warm_up(std::vector<Segment>& segments, const WarmUp& warm_up, Celsius from, const Segment& like) {
  auto ramp = make_ramp(from, warm_up.air, warm_up.rate, fmt::format("warm-up to {:g} °C", warm_up.air.value));
  Segment hold{.kind = SegmentKind::hold,
               .name = fmt::format("warm-up until the unit is at {:g} °C", warm_up.at_least.value),
               .target = warm_up.air,
               .duration = kWarmTime,
               .guaranteed_soak = true,
               .soak_band = warm_up.air - warm_up.at_least,
               .soak_sensor = kColdestThermometer,
               .soak_time = kWarmTime,
               .deadline = kLongestWait,
               .is_warm_up = true};
  for (auto* segment : {&ramp, &hold}) {
    segment->unit = like.unit;
    segment->cycle = like.cycle;
    segment->place = like.place;
    segments.push_back(std::move(*segment));
  }
}

}  // namespace

WarmUp make_warm_up(const RoomAir& room, const ChamberLimits& limits) {
  const auto at_least = room.warm_from();
  const auto air = std::min(std::max(kLeastAir, at_least + kAbove), limits.highest);
  return {.at_least = at_least, .air = air, .rate = std::min(kGentle, limits.fastest_heating)};
}

Result<void> add_warm_ups(Profile& profile, const WarmUp& warm_up) {
  if (!profile.warms_up || profile.segments.empty()) return {};
  const auto is_cold = [&](Celsius set_point) { return set_point < warm_up.at_least; };
  std::vector<Segment> segments;
  bool has_warm_up = false;
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    auto segment = profile.segments[i];
    const auto before = set_point_before(profile, i);
    if (i > 0 && segment.opens_door && is_cold(before)) {
      has_warm_up = true;
      append_warm_up(segments, warm_up, before, profile.segments[i - 1]);
      auto back = make_ramp(warm_up.air, before, warm_up.rate, fmt::format("return to {:g} °C", before.value));
      back.prompt = std::exchange(segment.prompt, {});
      back.unit = segment.unit;
      back.opens_door = std::exchange(segment.opens_door, false);
      back.cycle = segment.cycle;
      back.place = segment.place;
      segments.push_back(std::move(back));
    }
    segments.push_back(std::move(segment));
  }
  if (profile.until) {
    // The run does not end with its opening.
    for (auto& [from, closing] : profile.until->closing.expanded) {
      const auto last = closing.empty() ? profile.segments.back() : closing.back();
      const auto end = closing.empty() ? from : last.target;
      if (!is_cold(end)) continue;
      has_warm_up = true;
      append_warm_up(closing, warm_up, end, last);
      for (auto& added : std::span(closing).last(2)) added.cycle = -1;
    }
  } else if (is_cold(segments.back().target)) {
    has_warm_up = true;
    const auto last = segments.back();
    append_warm_up(segments, warm_up, last.target, last);
    for (auto& added : std::span(segments).last(2)) added.cycle = -1;
  }
  if (!has_warm_up) return {};
  if (!(warm_up.air > warm_up.at_least))
    return failure(
        FaultKind::usage, profile.name,
        fmt::format("the unit must be at {:g} °C before the door is opened, but the chamber reaches only {:g} "
                    "°C; set warm_up = false in [condensation] of the profile, or correct [room] of the rig",
                    warm_up.at_least.value, warm_up.air.value));
  profile.segments = std::move(segments);
  profile.warm_up = warm_up;
  return {};
}

}  // namespace gyrotherm::profile
