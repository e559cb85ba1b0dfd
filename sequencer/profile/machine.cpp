// SPDX-License-Identifier: Apache-2.0
#include "sequencer/profile/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sequencer/profile/released_blocks.hpp"

namespace gyrotherm::profile {
namespace {

const Segment& segment_at(const Profile& profile, int index) {
  assert(index >= 0 && static_cast<std::size_t>(index) < profile.segments.size());
  return profile.segments[static_cast<std::size_t>(index)];
}

/// Returns the state at the time `elapsed` after the start of a segment. If the segment is shorter than that, returns a
/// state of a later segment. A guaranteed soak starts with its first observation, so it is never skipped.
ProfileState enter_segment(const Profile& profile, int index, Duration elapsed) {
  const int count = static_cast<int>(profile.segments.size());
  for (; index < count; ++index) {
    const auto& segment = segment_at(profile, index);
    if (segment.guaranteed_soak || elapsed < segment.duration) {
      if (segment.kind == SegmentKind::ramp) return Ramping{index, elapsed};
      return Holding{index, elapsed, {}, {}};
    }
    elapsed -= segment.duration;
  }
  return Complete{};
}

bool is_inside_band(const Segment& segment, const std::optional<Celsius>& air) {
  if (segment.is_warm_up) return air && *air >= segment.target - segment.soak_band;
  return air && abs(*air - segment.target) <= segment.soak_band;
}

/// Returns true if the sensor is inside its band, its dwell is over and its slope is within the limit.
bool is_soak_counting(const Segment& segment, Duration inside_before, const Observation& seen) {
  if (!is_inside_band(segment, seen.air) || inside_before < segment.soak_dwell) return false;
  if (segment.soak_slope == CelsiusPerMinute{0}) return true;
  return seen.slope && std::abs(seen.slope->value) <= segment.soak_slope.value;
}

/// Returns the time since the end of the hold; negative before that end.
Duration time_past_end(const Segment& hold, Duration elapsed, Duration soaked) {
  const auto time = elapsed - hold.duration;
  return hold.guaranteed_soak ? std::min(time, soaked - hold.soak_time) : time;
}

/// Advances a hold. The same rules apply while its soak counts and while it waits.
template <class Hold>
ProfileState advance_hold(const Profile& profile, Hold hold, const Observation& seen) {
  const auto& segment = segment_at(profile, hold.segment);
  const bool is_soaking = is_soak_counting(segment, hold.inside, seen);
  hold.elapsed += seen.elapsed;
  hold.inside = is_inside_band(segment, seen.air) ? hold.inside + seen.elapsed : Duration::zero();
  if (is_soaking) hold.soaked += seen.elapsed;
  if (const auto over = time_past_end(segment, hold.elapsed, hold.soaked); over >= Duration::zero())
    return enter_segment(profile, hold.segment + 1, over);
  if (hold.elapsed > segment.deadline) return Overdue{hold.segment, hold.elapsed, hold.soaked};
  if (segment.guaranteed_soak && !is_soaking)
    return WaitingForSoak{hold.segment, hold.elapsed, hold.soaked, hold.inside};
  return Holding{hold.segment, hold.elapsed, hold.soaked, hold.inside};
}

ProfileState step(const Profile& profile, const Ramping& ramp, const Observation& seen) {
  return enter_segment(profile, ramp.segment, ramp.elapsed + seen.elapsed);
}
ProfileState step(const Profile& profile, const Holding& hold, const Observation& seen) {
  return advance_hold(profile, hold, seen);
}
ProfileState step(const Profile& profile, const WaitingForSoak& hold, const Observation& seen) {
  return advance_hold(profile, hold, seen);
}
ProfileState step(const Profile&, const Overdue& overdue, const Observation&) { return overdue; }
ProfileState step(const Profile&, const Complete& complete, const Observation&) { return complete; }

Celsius set_point(const Profile& profile, const Ramping& ramp) {
  const auto& segment = segment_at(profile, ramp.segment);
  const auto from = set_point_before(profile, static_cast<std::size_t>(ramp.segment));
  return from + (segment.target - from) * (to_seconds(ramp.elapsed) / to_seconds(segment.duration));
}
Celsius set_point(const Profile& profile, const Complete&) { return profile.segments.back().target; }
Celsius set_point(const Profile& profile, const auto& hold) { return segment_at(profile, hold.segment).target; }

struct SegmentPhase {
  Phase phase{};
  int segment{};
  Duration elapsed{};
  Duration soaked{};
};

SegmentPhase segment_phase(const Profile&, const Ramping& s) { return {Phase::ramping, s.segment, s.elapsed, {}}; }
SegmentPhase segment_phase(const Profile&, const Holding& s) {
  return {Phase::holding, s.segment, s.elapsed, s.soaked};
}
SegmentPhase segment_phase(const Profile&, const WaitingForSoak& s) {
  return {Phase::waiting_for_soak, s.segment, s.elapsed, s.soaked};
}
SegmentPhase segment_phase(const Profile&, const Overdue& s) {
  return {Phase::overdue, s.segment, s.elapsed, s.soaked};
}

/// A complete profile is stored as the end of its last segment.
SegmentPhase segment_phase(const Profile& profile, const Complete&) {
  const auto& last = profile.segments.back();
  const auto soaked = last.guaranteed_soak ? last.soak_time : Duration::zero();
  return {Phase::complete, static_cast<int>(profile.segments.size()) - 1, shortest(last), soaked};
}

SegmentPhase segment_phase(const Profile& profile, const ProfileState& state) {
  return std::visit([&](const auto& s) { return segment_phase(profile, s); }, state);
}

bool can_have_phase(const Segment& segment, Phase phase) {
  switch (phase) {
    case Phase::ramping: return segment.kind == SegmentKind::ramp;
    case Phase::holding:
    case Phase::overdue: return segment.kind == SegmentKind::hold;
    case Phase::waiting_for_soak: return segment.guaranteed_soak;
    case Phase::complete: return true;
  }
  return false;
}

tl::unexpected<Fault> progress_mismatch(std::string what) {
  return failure(FaultKind::mismatch, "progress of the profile", std::move(what));
}

}  // namespace

ProfileState begin(const Profile& profile) { return enter_segment(profile, 0, {}); }

ProfileState next(const Profile& profile, const ProfileState& state, const Observation& observation) {
  assert(observation.elapsed >= Duration::zero());
  auto after = std::visit([&](const auto& s) { return step(profile, s, observation); }, state);
  // The last hold of an open profile continues until a block is added.
  if (std::holds_alternative<Complete>(after) && is_open(profile))
    return next_while_paused(profile, state, observation);
  return after;
}

ProfileState next_while_paused(const Profile& profile, ProfileState state, const Observation& observation) {
  const auto leave = [&](auto& hold) {
    if (!is_inside_band(segment_at(profile, hold.segment), observation.air)) hold.inside = {};
  };
  if (auto* holding = std::get_if<Holding>(&state)) leave(*holding);
  if (auto* waiting = std::get_if<WaitingForSoak>(&state)) leave(*waiting);
  return state;
}

ProfileState restart_deadline(ProfileState state) {
  const auto* overdue = std::get_if<Overdue>(&state);
  if (!overdue) return state;
  // An elapsed time of at least one second keeps an answered prompt from being repeated.
  return Holding{overdue->segment, std::max(overdue->soaked, kSecond), overdue->soaked, {}};
}

Celsius demanded_set_point(const Profile& profile, const ProfileState& state) {
  return std::visit([&](const auto& s) { return set_point(profile, s); }, state);
}

ProfilePosition profile_position(const Profile& profile, const ProfileState& state) {
  const auto now = segment_phase(profile, state);
  return {.segment = now.segment,
          .cycle = segment_at(profile, now.segment).cycle,
          .phase = now.phase,
          .in_segment = now.elapsed,
          .soaked = now.soaked,
          .set_point = demanded_set_point(profile, state)};
}

bool unit_may_be_off(const Profile& profile, const ProfileState& state) {
  const auto now = segment_phase(profile, state);
  const bool was_off = now.segment > 0 && segment_at(profile, now.segment - 1).unit.off;
  return segment_at(profile, now.segment).unit.off || (was_off && now.elapsed == Duration{});
}

const std::string& soak_sensor(const Profile& profile, const ProfileState& state) {
  return segment_at(profile, segment_phase(profile, state).segment).soak_sensor;
}

Result<ProfileState> restore_state(const Profile& profile, const ProfilePosition& progress) {
  const auto count = profile.segments.size();
  if (progress.segment < 0 || static_cast<std::size_t>(progress.segment) >= count)
    return progress_mismatch(fmt::format("segment {} of {}", progress.segment + 1, count));
  const auto& segment = segment_at(profile, progress.segment);
  if (!can_have_phase(segment, progress.phase))
    return progress_mismatch(fmt::format("segment {} cannot be {}", progress.segment + 1, name(progress.phase)));
  if (progress.in_segment < Duration::zero() || progress.soaked < Duration::zero())
    return progress_mismatch(fmt::format("segment {} has a negative time", progress.segment + 1));
  if (progress.phase == Phase::ramping && progress.in_segment >= segment.duration)
    return progress_mismatch(fmt::format("segment {} is past its end", progress.segment + 1));
  switch (progress.phase) {
    case Phase::ramping: return Ramping{progress.segment, progress.in_segment};
    case Phase::holding: return Holding{progress.segment, progress.in_segment, progress.soaked, {}};
    case Phase::waiting_for_soak: return WaitingForSoak{progress.segment, progress.in_segment, progress.soaked, {}};
    case Phase::overdue: return Overdue{progress.segment, progress.in_segment, progress.soaked};
    case Phase::complete: return Complete{};
  }
  return progress_mismatch("unknown phase");
}

Duration time_left(const Profile& profile, const ProfileState& state) {
  if (std::holds_alternative<Complete>(state)) return Duration::zero();
  const auto now = segment_phase(profile, state);
  const auto& segment = segment_at(profile, now.segment);
  auto left = std::max(Duration::zero(), -time_past_end(segment, now.elapsed, now.soaked));
  for (int i = now.segment + 1; i < static_cast<int>(profile.segments.size()); ++i)
    left += shortest(segment_at(profile, i));
  return left;
}

}  // namespace gyrotherm::profile
