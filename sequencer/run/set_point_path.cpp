// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/set_point_path.hpp"

#include <algorithm>

#include "core/process.hpp"

namespace gyrotherm::run {
namespace {

/// Longest step. After a longer pause the set point does not jump.
constexpr Duration kLongestStep = std::chrono::seconds(5);
constexpr Kelvins kRounding{1e-9};

const CelsiusPerMinute& ramp_limit(Celsius from, Celsius to, const profile::ChamberLimits& limits) {
  return to > from ? limits.fastest_heating : limits.fastest_cooling;
}

}  // namespace

Celsius step_towards(Celsius from, Celsius goal, const profile::ChamberLimits& limits, Duration time) {
  const auto reach = ramp_limit(from, goal, limits) * time + kRounding;
  const auto way = goal - from;
  if (abs(way) <= reach) return goal;
  return from + (way < Kelvins{0} ? -reach : reach);
}

Celsius clamp_to_limits(Celsius target, const profile::ChamberLimits& limits) {
  return std::clamp(target, limits.lowest, limits.highest);
}

std::int64_t count_set_points(const profile::Profile& profile, const profile::ChamberLimits& limits, Duration every) {
  const auto step = std::max(every, Duration(kSecond));
  std::int64_t count = 1;
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    auto moving = segment.kind == profile::SegmentKind::ramp ? segment.duration : Duration{};
    if (const auto from = set_point_before(profile, i); moving == Duration{} && from != segment.target)
      moving = abs(segment.target - from) / ramp_limit(from, segment.target, limits);
    count += (moving + step - Duration(1)) / step;
  }
  return count;
}

SetPointPath::SetPointPath(const profile::ChamberLimits& limits, Kelvins tolerance, Duration every, Celsius sent,
                           Duration at)
    : limits_(limits),
      tolerance_(tolerance),
      every_(every),
      held_(sent),
      base_(clamp_to_limits(sent, limits)),
      at_(at),
      tried_(at - every) {}

Result<void> SetPointPath::advance(io::InstrumentIo& io, Celsius goal, Duration at) {
  if (is_at(goal) || (!begins_ && at - tried_ < every_)) return {};
  const auto time = std::min(at - at_, std::max(every_, kLongestStep));
  const auto target = begins_ ? base_ : step_towards(base_, goal, limits_, time);
  ensure(target >= limits_.lowest && target <= limits_.highest, "a set point lies within the limits");
  ensure(begins_ || abs(target - base_) <= ramp_limit(base_, target, limits_) * time + kRounding * 2,
         "a set point moves no faster than the ramp limit");
  tried_ = at;
  const auto taken = io.send_set_point(target);
  known_ = taken.has_value();
  if (!taken) {
    attempted_ = target;
    ++refusals_;
    ++(taken.error().kind == FaultKind::timeout ? unconfirmed_ : missed_);
    refusal_ = text(taken.error());
    return taken;
  }
  held_ = base_ = target;
  attempted_.reset();
  at_ = at;
  begins_ = false;
  refusals_ = 0;
  return taken;
}

void SetPointPath::begin_at(Celsius here) {
  base_ = clamp_to_limits(here, limits_);
  begins_ = true;
}

void SetPointPath::accept_as_sent(Celsius set_point) {
  held_ = set_point;
  known_ = true;
  attempted_.reset();
}

Celsius SetPointPath::expected(Celsius shown) const {
  return attempted_ && abs(shown - *attempted_) < abs(shown - held_) ? *attempted_ : held_;
}

}  // namespace gyrotherm::run
