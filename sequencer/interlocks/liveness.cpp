// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/liveness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrotherm::interlocks {
namespace {

constexpr double kNoiseWeight = 1.0 / 300;  ///< weight of one reading
constexpr double kTwoStepThreshold = 1.5;   ///< two steps, with a margin for rounding
constexpr double kMaxNoiseShare = 0.9;      ///< largest share that is used

/// Limit of −ln p, where p is the probability that noise makes the readings identical. The limit corresponds to p ≈
/// 1e-13.
constexpr double kImprobabilityLimit = 30;
/// Readings are declared frozen after this multiple of the longest earlier spell of identical readings.
constexpr int kLongestSpellFactor = 5;
/// An instrument whose noise is unknown is declared frozen if its readings stay identical for kAirMovedTime while the
/// air changes by kAirMoved.
constexpr Kelvins kAirMoved{10};
constexpr Duration kAirMovedTime = std::chrono::minutes(10);
/// A channel that moved is declared frozen after this number of missing steps, if the air has moved on by kAheadK in
/// the same direction.
constexpr double kMissingSteps = 20;
constexpr double kAheadK = 1;
constexpr std::size_t kReadingsOfPace = 60, kLeastReadingsOfPace = 20;
/// The air follows a set point within this time; later changes are noise.
constexpr Duration kSettlingTime = std::chrono::minutes(1);
constexpr Kelvins kSameSetPoint{0.02};
/// The absence of counts is a fault once the Earth's rate would have produced this many.
constexpr double kExpectedCounts = 20;
constexpr double kResponseShare = 0.05;  ///< share of response_step
constexpr int kStuckReadings = 120;
/// The fastest plausible change of a solid body's temperature. Applies even if the rig file has a lower limit.
constexpr CelsiusPerMinute kFastestBody{15};
/// Readings that give the motion of a channel. The motion includes the updates of a chamber that shows a new value
/// every few seconds.
constexpr std::size_t kStepsOfMotion = 5;

/// Updates the time since the set point last moved. Switching a unit on or off restarts that time, because the unit's
/// temperature then changes.
void update_rest_time(const Sample& sample, const LivenessSecond& second, LivenessMemory& memory) {
  const auto& chamber = sample.chamber.value;
  memory.at_rest += second.elapsed;
  if (std::exchange(memory.units_were_off, second.gyro_is_off) != second.gyro_is_off) memory.at_rest = {};
  if (!chamber || std::isnan(chamber->set_point.value)) return;
  if (memory.set_point && abs(chamber->set_point - *memory.set_point) <= kSameSetPoint) return;
  memory.set_point = chamber->set_point;
  memory.at_rest = {};
}

/// Returns the channels of an instrument that move.
std::vector<MovingChannel> find_moving(const std::vector<std::size_t>& columns, const LivenessMemory& memory) {
  std::vector<MovingChannel> moving;
  for (const auto i : columns)
    if (i < memory.last_minute.size() && memory.last_minute[i].pace() != 0)
      moving.push_back({.pace = memory.last_minute[i].pace(), .step = memory.thermometers[i].step()});
  return moving;
}

/// Adds a second of a spell. A body that follows the air does not stop while the air moves on.
void update_moving(std::vector<MovingChannel>& moving, Kelvins air_moved) {
  for (auto& channel : moving) {
    channel.air_ahead = channel.pace > 0 ? air_moved.value : -air_moved.value;
    if (channel.air_ahead >= 0) channel.missing_steps += std::abs(channel.pace) / channel.step;
  }
}

/// Returns whether a channel would have changed its last digit many times if it had followed the air.
bool lacks_steps(const MovingChannel& channel) {
  return channel.missing_steps >= kMissingSteps && channel.air_ahead >= kAheadK;
}

/// Updates the spell of one instrument. `identical` is the smallest count of identical readings among its channels.
void update_spell(const InterlockLimits& limits, int identical, double improbability, const std::optional<Celsius>& air,
                  Duration elapsed, IdenticalSpell& memory) {
  if (identical == 0) {
    const auto lasted = memory.frozen ? Duration{} : memory.duration;
    memory = {.longest_before = std::max(memory.longest_before, lasted)};
    memory.air_before = air;
    return;
  }
  memory.samples = identical;
  memory.duration += elapsed;
  if (air && !memory.air_before) memory.air_before = air;
  if (air) memory.air_moved = std::max(memory.air_moved, abs(*air - *memory.air_before));
  if (air) update_moving(memory.moving, *air - *memory.air_before);
  const bool is_longest = memory.duration > kLongestSpellFactor * memory.longest_before;
  const bool beyond_noise = improbability > kImprobabilityLimit && is_longest;
  const bool beyond_movement = is_longest && std::ranges::any_of(memory.moving, lacks_steps);
  const bool beyond_air = memory.air_moved >= kAirMoved && memory.duration >= kAirMovedTime;
  const bool is_found = memory.duration >= limits.frozen_after && (beyond_noise || beyond_movement || beyond_air);
  memory.frozen = memory.frozen || is_found;  // also if the air returns
}

void update_thermometers(const InterlockLimits& limits, const Sample& sample, Duration elapsed,
                         LivenessMemory& memory) {
  const bool is_settled = memory.at_rest >= kSettlingTime;
  memory.thermometers.resize(sample.thermometers.size());
  memory.last_minute.resize(sample.thermometers.size());
  memory.instruments.resize(limits.instruments.size());
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    if (const auto& reading = sample.thermometers[i].value) {
      memory.thermometers[i].add(reading->value, is_settled);
      memory.last_minute[i].add(reading->value);
    }
  const auto air = sample.chamber.value ? std::optional(sample.chamber.value->air) : std::nullopt;
  for (std::size_t k = 0; k < limits.instruments.size(); ++k) {
    std::optional<int> identical;
    double improbability = 0;
    for (const auto i : limits.instruments[k].columns) {
      if (i >= sample.thermometers.size() || !sample.thermometers[i].value) continue;
      identical = std::min(identical.value_or(memory.thermometers[i].identical()), memory.thermometers[i].identical());
      improbability += memory.thermometers[i].improbability();
    }
    if (identical) update_spell(limits, *identical, improbability, air, elapsed, memory.instruments[k]);
    if (identical == 0) memory.instruments[k].moving = find_moving(limits.instruments[k].columns, memory);
  }
  if (!air) return;
  memory.air_noise.add(air->value, is_settled);
  update_spell(limits, memory.air_noise.identical(), memory.air_noise.improbability(), {}, elapsed, memory.air);
}

/// Returns the number of counts that the Earth's rate produces in a time.
double expected_counts(const AxisLimits& axis, Duration time) {
  if (!axis.earth_rate || axis.arcsec_per_count == 0) return 0;
  return std::abs(axis.earth_rate->value * to_seconds(time) / axis.arcsec_per_count);
}

/// Returns [limits] gyro_band. Without that key, the band is ten times the unit's largest bias plus half of the Earth's
/// rate plus 5 °/h, and at most 1000 °/h. The band is narrow enough to detect a scale that is wrong by the factor 57
/// (rad for °) at the Earth's rate, and wide enough that a bias outside the data sheet does not end the run.
DegreesPerHour band_around_earth_rate(const InterlockLimits& limits, const AxisLimits& axis) {
  constexpr double kMaxBand = 1000, kMinBand = 5;  // °/h
  constexpr double kBiasFactor = 10;
  if (limits.gyro_band) return *limits.gyro_band;
  if (!axis.largest_bias) return {kMaxBand};
  return {std::min(kMaxBand, kMinBand + kBiasFactor * axis.largest_bias->value + std::abs(axis.earth_rate->value) / 2)};
}

void update_axis(const InterlockLimits& limits, const AxisLimits& axis, const LivenessSecond& second,
                 std::int64_t pulses, Duration interval, AxisLiveness& memory) {
  memory.noise.add(static_cast<double>(pulses), true);
  const auto longer = [&](Duration so_far, bool so) { return so ? so_far + second.elapsed : Duration{}; };
  memory.identical = longer(memory.identical, memory.noise.identical() > 0);
  memory.without_counts = longer(memory.without_counts, pulses == 0);
  memory.frozen = memory.identical >= limits.gyro_dead_after && memory.noise.improbability() > kImprobabilityLimit;
  memory.no_counts = memory.without_counts >= limits.gyro_dead_after &&
                     expected_counts(axis, memory.without_counts) >= kExpectedCounts;
  if (second.units_are_moved || !axis.earth_rate) {
    memory.block = {}, memory.arcsec = 0, memory.deviating_rate.reset();
    return;
  }
  memory.arcsec += static_cast<double>(pulses) * axis.arcsec_per_count;
  memory.block += interval;
  if (memory.block < limits.gyro_dead_after) return;
  const DegreesPerHour rate{std::exchange(memory.arcsec, 0) / to_seconds(std::exchange(memory.block, {}))};
  const double expected = second.is_turned ? -axis.earth_rate->value : axis.earth_rate->value;
  memory.deviating_rate =
      std::abs(rate.value - expected) > band_around_earth_rate(limits, axis).value ? std::optional(rate) : std::nullopt;
}

void update_units(const InterlockLimits& limits, const Sample& sample, const LivenessSecond& second,
                  LivenessMemory& memory) {
  memory.units.resize(sample.units.size());
  for (std::size_t u = 0; u < sample.units.size(); ++u) {
    const auto& count = sample.units[u].count.value;
    if (second.gyro_is_off) memory.units[u].clear();
    if (second.gyro_is_off || !count || u >= limits.units.size()) continue;
    const auto& axes = limits.units[u].axes;
    memory.units[u].resize(axes.size());
    for (std::size_t a = 0; a < axes.size() && a < count->pulses.size(); ++a)
      update_axis(limits, axes[a], second, count->pulses[a], count->interval, memory.units[u][a]);
  }
}

/// Updates the change of air and set point since any thermometer last moved.
void update_response(const InterlockLimits& limits, const Sample& sample, ResponseMemory& memory) {
  const auto& chamber = sample.chamber.value;
  const auto same_size = memory.thermometers.size() == sample.thermometers.size();
  bool is_moved = !same_size, is_read = false;
  for (std::size_t i = 0; i < sample.thermometers.size() && same_size; ++i) {
    const auto value = known_value(sample.thermometers[i]);
    auto& from = memory.thermometers[i];
    if (!value) continue;
    is_read = true;
    if (!from) from = value;
    is_moved = is_moved || abs(*value - *from) >= limits.response_step * kResponseShare;
  }
  if (is_moved) {
    memory = {};
    for (const auto& reading : sample.thermometers) memory.thermometers.push_back(known_value(reading));
  }
  if (!chamber || !is_read) return;
  const bool has_set_point = !std::isnan(chamber->set_point.value);
  if (!memory.air) memory.air = chamber->air;
  if (!memory.set_point && has_set_point) memory.set_point = chamber->set_point;
  memory.demanded_change = abs(chamber->air - *memory.air);
  if (has_set_point)
    memory.demanded_change = std::max(memory.demanded_change, abs(chamber->set_point - *memory.set_point));
}

/// Returns the speed of a step in the direction of `sign`, in K/s.
double directed_speed(const MotionStep& step, double sign) {
  const double seconds = to_seconds(step.time);
  return seconds > 0 ? std::copysign(1, sign) * step.change.value / seconds : 0;
}

/// Returns the speed in the direction of `sign`, K/s, that explains a change: the air's fastest motion, or the median
/// of the other thermometers' sustained motions if that is greater. A single step of a thermometer hardly counts,
/// because all channels of one instrument may jump together.
double explained_speed(const LivenessMemory& memory, std::size_t column, double sign) {
  std::vector<double> others;
  for (std::size_t i = 0; i < memory.past.size(); ++i)
    if (i != column && memory.past[i].motion.step()) others.push_back(memory.past[i].motion.sustained(sign));
  double speed = std::max(0.0, memory.air_motion.fastest(sign));
  if (others.empty()) return speed;
  const auto median = others.begin() + static_cast<std::ptrdiff_t>((others.size() - 1) / 2);
  std::ranges::nth_element(others, median);
  return std::max(speed, *median);
}

/// Returns whether a change is too fast for a solid body, and faster than the changes of everything else.
bool is_jump(const LivenessMemory& memory, std::size_t column, const MotionStep& step, double fastest_body) {
  const double change = step.change.value, seconds = to_seconds(step.time);
  if (std::abs(change) <= fastest_body * seconds) return false;
  return std::abs(change) > (fastest_body + explained_speed(memory, column, change)) * seconds;
}

/// Returns whether a body only continues its motion towards the air, as a heavy part does after a fast change.
bool follows_air(const RecentMotion& motion, const MotionStep& step, const std::optional<Celsius>& air,
                 double fastest_body) {
  const double change = step.change.value;
  if (!air || (*air - *motion.last()).value * change <= 0) return false;
  return std::abs(change) <= (fastest_body + std::max(0.0, motion.previous(change))) * to_seconds(step.time);
}

/// Withdraws recent jumps that the present motion of everything else explains: at the beginning of a fast change the
/// others may not have moved yet.
void withdraw_jumps(const LivenessMemory& memory, std::size_t column, double fastest_body, ThermometerPast& past) {
  std::erase_if(past.recent_jumps, [&](RecentJump& jump) {
    if (++jump.age > kStepsOfMotion) return true;
    if (is_jump(memory, column, jump.step, fastest_body)) return false;
    past.jumped = past.jumped - jump.step.change;
    return true;
  });
}

/// Sums the jumps of each thermometer. A jump and its reversal cancel each other.
void update_jumps(const InterlockLimits& limits, const Sample& sample, const LivenessSecond& second,
                  LivenessMemory& memory) {
  const auto time = second.elapsed + second.missed;
  memory.past.resize(sample.thermometers.size());
  const auto air = sample.chamber.value ? std::optional(sample.chamber.value->air) : std::nullopt;
  memory.air_motion.add(air, time);
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    memory.past[i].motion.add(known_value(sample.thermometers[i]), time);
  const double fastest_body = std::max(kFastestBody, limits.thermometers_fastest).value / 60;
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i) {
    auto& past = memory.past[i];
    const auto step = past.motion.step();
    if (!step) continue;
    withdraw_jumps(memory, i, fastest_body, past);
    if (is_jump(memory, i, *step, fastest_body) && !follows_air(past.motion, *step, air, fastest_body)) {
      past.jumped = past.jumped + step->change;
      past.recent_jumps.push_back({.step = *step});
    } else if (abs(past.jumped) <= limits.drift) {
      past.jumped = {};
      past.recent_jumps.clear();
    }
  }
}

/// Ignores the jump of a stuck thermometer when it starts to change again.
void ignore_stuck(const Sample& sample, LivenessMemory& memory) {
  for (std::size_t i = 0; i < sample.thermometers.size() && i < memory.past.size(); ++i)
    if (memory.thermometers[i].identical() >= kStuckReadings) memory.past[i] = {};
}

Fault frozen_fault(const std::string& what) { return {FaultKind::out_of_range, "", what}; }

}  // namespace

void Noise::add(double value, bool at_rest) {
  const double change = last_ ? value - *last_ : 0;
  const bool is_first = !last_;
  last_ = value;
  if (is_first) return;
  if (change == 0) {
    ++identical_;
    identical_at_rest_ += at_rest ? 1 : 0;
    return;
  }
  // Identical readings reduce the share only when their spell ends, so a frozen channel keeps its learnt noise.
  share_ *= std::pow(1 - kNoiseWeight, std::exchange(identical_at_rest_, 0));
  const bool is_noise = last_change_ * change < 0 && std::abs(change) > kTwoStepThreshold * step_;
  if (at_rest) share_ += kNoiseWeight * ((is_noise ? 1 : 0) - share_);
  step_ = std::min(step_, std::abs(change));
  last_change_ = change;
  identical_ = 0;
}

void LastMinute::add(double value) {
  values_.push_back(value);
  if (values_.size() > kReadingsOfPace) values_.pop_front();
}

std::optional<double> LastMinute::last() const {
  return values_.empty() ? std::nullopt : std::optional(values_.back());
}

double LastMinute::pace() const {
  if (values_.size() < kLeastReadingsOfPace) return 0;
  return (values_.back() - values_.front()) / static_cast<double>(values_.size() - 1);
}

void RecentMotion::add(const std::optional<Celsius>& value, Duration elapsed) {
  unseen_ += elapsed;
  has_step_ = value && last_;
  if (!value) return;
  const auto time = std::exchange(unseen_, Duration{});
  const auto before = std::exchange(last_, value);
  if (!before) return;
  steps_.push_back({.change = *value - *before, .time = time});
  if (steps_.size() > kStepsOfMotion) steps_.pop_front();
}

std::optional<MotionStep> RecentMotion::step() const { return has_step_ ? std::optional(steps_.back()) : std::nullopt; }

double RecentMotion::mean(std::size_t omitted) const {
  double change = 0, seconds = 0;
  for (std::size_t i = 0; i + omitted < steps_.size(); ++i)
    change += steps_[i].change.value, seconds += to_seconds(steps_[i].time);
  return seconds > 0 ? change / seconds : 0;
}

double RecentMotion::previous(double sign) const { return std::copysign(1, sign) * mean(1); }

double RecentMotion::fastest(double sign) const {
  if (!has_step_) return 0;
  return std::max(directed_speed(steps_.back(), sign), std::copysign(1, sign) * mean());
}

double RecentMotion::sustained(double sign) const {
  if (!has_step_ || steps_.size() < 2) return 0;
  const double both = std::min(directed_speed(steps_.back(), sign), directed_speed(steps_[steps_.size() - 2], sign));
  return std::max(both, std::copysign(1, sign) * mean());
}

double Noise::improbability() const { return -identical_ * std::log1p(-std::min(share_, kMaxNoiseShare)); }

void remember(const InterlockLimits& limits, const Sample& sample, const LivenessSecond& second,
              LivenessMemory& memory) {
  update_rest_time(sample, second, memory);
  update_thermometers(limits, sample, second.elapsed, memory);
  update_units(limits, sample, second, memory);
  Sample alive = sample;
  mask_dead_readings(limits, memory, alive);
  update_response(limits, alive, memory.response);
  update_jumps(limits, alive, second, memory);
  ignore_stuck(alive, memory);
}

bool is_frozen(const InterlockLimits& limits, const LivenessMemory& memory, std::size_t column) {
  for (std::size_t k = 0; k < memory.instruments.size() && k < limits.instruments.size(); ++k)
    if (memory.instruments[k].frozen && std::ranges::count(limits.instruments[k].columns, column) > 0) return true;
  return false;
}

void mask_dead_readings(const InterlockLimits& limits, const LivenessMemory& memory, Sample& sample) {
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    if (sample.thermometers[i].value && is_frozen(limits, memory, i))
      sample.thermometers[i].value = tl::unexpected(frozen_fault("the instrument is frozen"));
  for (std::size_t u = 0; u < sample.units.size() && u < memory.units.size(); ++u)
    if (sample.units[u].count.value && !sample.units[u].count.value->pulses.empty() &&
        std::ranges::any_of(memory.units[u], &AxisLiveness::is_dead))
      sample.units[u].count.value = tl::unexpected(frozen_fault("the gyro is dead"));
}

}  // namespace gyrotherm::interlocks
