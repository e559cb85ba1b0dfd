// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/measurement_checks.hpp"

#include <cmath>

#include "core/humidity.hpp"

namespace gyrotherm::interlocks {
namespace {

/// Largest difference of a thermometer's rate from the median of all rates while the set point is constant, beyond what
/// is left of the last ramp.
constexpr double kLargestRateDifference_k_per_min = 1;

/// Distance of the air from the range that the set points explain: more than chambers overshoot when they change
/// direction, and twice as much.
constexpr Kelvins kUnexplained{3}, kFarOutside{6};
constexpr Celsius kRoom{22};
/// Time for which the air must be outside. It exceeds the time in which a starting compressor disturbs the air.
constexpr Duration kUnexplainedFor = std::chrono::seconds(20);
/// In a run this short, the air has had no time for a greater distance.
constexpr Duration kShortRun = std::chrono::minutes(2);
constexpr Kelvins kUnexplainedInShortRun{1};
/// Change of the air over a minute that counts as an approach to the set point.
constexpr CelsiusPerMinute kApproach{0.2};

/// Returns whether the chamber conditions the air, as far as is known. In other states another interlock acts, or the
/// air drifts.
bool may_condition(ChamberActivity activity) {
  return activity == ChamberActivity::running || activity == ChamberActivity::unknown;
}

/// Returns the distance of the air from the range that the set points explain; 0 inside the range, and once the air has
/// followed the set points.
Kelvins unexplained_distance(const ExplainedAir& known, const ChamberState& chamber) {
  if (!known.first || known.has_followed || !may_condition(chamber.activity)) return {};
  return std::max({Kelvins{}, known.lowest - chamber.air, chamber.air - known.highest});
}

/// Returns whether the air is far from the range. Air that moves to the temperature of the room is not: a door without
/// a switch may be open.
bool is_far_outside(ExplainedAir known, const ChamberState& chamber) {
  known.lowest = std::min(known.lowest, kRoom);
  known.highest = std::max(known.highest, kRoom);
  return unexplained_distance(known, chamber) > kFarOutside;
}

std::string describe_unexplained(const ExplainedAir& known, const ChamberState& chamber) {
  return fmt::format(
      "the air moves away from the set point: {:.1f} °C, but air and set points of this run so far were {:.1f} … "
      "{:.1f} "
      "°C; check scale and unit of the set point in the description of the chamber",
      chamber.air.value, known.lowest.value, known.highest.value);
}

std::string describe_identical(const std::string& what, Duration time) {
  return fmt::format("{} identical to the last digit for {}", what, format_duration(time));
}

/// Describes the fault of an axis; empty: none.
std::string axis_fault(const AxisLimits& axis, const AxisLiveness& seen, bool is_turned) {
  const double expected = axis.earth_rate ? (is_turned ? -1 : 1) * axis.earth_rate->value : 0;
  if (seen.no_counts)
    return fmt::format("gyro {}: no counts for {}, expected {:.3g} °/h at rest", axis.label,
                       format_duration(seen.without_counts), expected);
  if (seen.frozen) return describe_identical(fmt::format("gyro {}: its counts are", axis.label), seen.identical);
  if (seen.deviating_rate)
    return fmt::format("gyro {}: {:.3g} °/h on average, expected {:.3g} °/h at rest", axis.label,
                       seen.deviating_rate->value, expected);
  return {};
}

/// Returns true if another unit that is not dropped delivers counts.
bool has_another_counting_unit(const CheckInputs& in, std::size_t unit) {
  for (std::size_t other = 0; other < in.sample.units.size(); ++other)
    if (other != unit && !in.is_dropped(other) && in.sample.units[other].count.value) return true;
  return false;
}

}  // namespace

std::vector<CheckResult> find_unexplained_air(const CheckInputs& in) {
  if (!in.chamber()) return {};
  const auto& known = in.memory.explained;
  if (unexplained_distance(known, *in.chamber()) <= kUnexplained) return {};
  return {CheckResult{.text = describe_unexplained(known, *in.chamber()),
                      .grave = is_far_outside(known, *in.chamber()),
                      .subject = "set point",
                      .after = kUnexplainedFor}};
}

std::string leaving_refusal(const InterlockLimits& limits, const InterlockMemory& memory, const Sample& sample) {
  constexpr Duration kSilent = std::chrono::seconds(2);
  const auto& chamber = sample.chamber.value;
  if (!chamber && memory.since_last_air >= kSilent)
    return fmt::format("the chamber has given no valid reading for {}, so its set point is not confirmed",
                       format_duration(memory.since_last_air));
  for (const auto id : {InterlockId::restarted, InterlockId::restarted_off, InterlockId::not_taken})
    if (memory.is_cause_present(id)) return memory.most_affected_watch(id).text;
  if (!chamber || !memory.expected || !memory.set_point || !may_condition(chamber->activity)) return {};
  const auto& known = memory.explained;
  const auto permitted = known.watched < kShortRun ? kUnexplainedInShortRun : kUnexplained;
  if (unexplained_distance(known, *chamber) > permitted) return describe_unexplained(known, *chamber);
  const auto is_near = [&](Celsius where) { return abs(chamber->air - where) <= limits.follow_band; };
  if (is_near(*memory.expected) || is_near(*memory.set_point)) return {};
  const auto rate = memory.air.rate();
  const auto approach = (*memory.set_point - chamber->air).value > 0 ? 1 : -1;
  if (!rate || rate->value * approach >= kApproach.value) return {};
  return fmt::format("the air is at {:.1f} °C and does not approach the set point of {:.1f} °C", chamber->air.value,
                     memory.set_point->value);
}

std::vector<CheckResult> find_frozen_instruments(const CheckInputs& in) {
  const auto& seen = in.memory.liveness;
  std::vector<CheckResult> all;
  if (seen.air.frozen)
    all.push_back({.text = describe_identical("the chamber's air is", seen.air.duration), .subject = "chamber"});
  for (std::size_t k = 0; k < seen.instruments.size() && k < in.limits.instruments.size(); ++k) {
    if (!seen.instruments[k].frozen) continue;
    const auto& [name, columns] = in.limits.instruments[k];
    const auto what = columns.size() == 1 ? in.channel(columns.front()) + " is" : "every channel of " + name + " is";
    all.push_back({.text = describe_identical(what, seen.instruments[k].duration), .subject = name});
  }
  return all;
}

std::vector<CheckResult> find_dead_axes(const CheckInputs& in) {
  const auto& units = in.memory.liveness.units;
  std::vector<CheckResult> all;
  for (std::size_t u = 0; u < units.size() && u < in.limits.units.size() && !in.facts.gyro_is_off; ++u) {
    if (in.is_dropped(u)) continue;
    const bool is_mild = in.continues_without(u) && has_another_counting_unit(in, u);
    for (std::size_t a = 0; a < units[u].size(); ++a) {
      const auto& axis = in.limits.units[u].axes[a];
      auto trouble = axis_fault(axis, units[u][a], in.facts.is_turned);
      if (trouble.empty()) continue;
      all.push_back(
          {.text = std::move(trouble), .subject = axis.label, .at_most = is_mild ? Reaction::warn : Reaction::abort});
    }
  }
  return all;
}

std::vector<CheckResult> find_missing_response(const CheckInputs& in) {
  const auto demanded_change = in.memory.liveness.response.demanded_change;
  if (demanded_change < in.limits.response_step) return {};
  return {{.text = fmt::format("the chamber's air or set point changed by {:.0f} K, but no thermometer responded",
                               demanded_change.value)}};
}

std::vector<CheckResult> find_drifting_thermometers(const CheckInputs& in) {
  const auto& seen = in.memory.liveness;
  std::vector<CheckResult> all;
  const auto& differences = in.memory.rate_differences;
  for (std::size_t i = 0; i < seen.past.size(); ++i) {
    if (abs(seen.past[i].jumped) > in.limits.drift) {
      all.push_back(in.thermometer_result(i, fmt::format("{} jumped by {:+.1f} K, faster than it can change",
                                                         in.channel(i), seen.past[i].jumped.value)));
      continue;
    }
    const auto difference = i < differences.size() ? differences[i] : std::nullopt;
    if (!difference || std::abs(difference->now) - difference->least <= kLargestRateDifference_k_per_min) continue;
    const auto rate = in.memory.thermometers[i].rate();
    all.push_back(
        in.thermometer_result(i, fmt::format("{} changes by {:+.1f} °C in a minute while everything else is at rest",
                                             in.channel(i), rate->value)));
  }
  return all;
}

std::optional<ColdestReading> find_coldest(const InterlockLimits& limits, const Sample& sample) {
  const auto is_in_air = [&](std::size_t column) { return std::ranges::count(limits.air_thermometers, column) > 0; };
  const bool all_in_air = limits.air_thermometers.size() >= sample.thermometers.size();
  std::optional<ColdestReading> coldest;
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i) {
    const auto value = known_value(sample.thermometers[i]);
    if (!value || (is_in_air(i) && !all_in_air)) continue;
    if (!coldest || *value < coldest->value) coldest = ColdestReading{*value, i};
  }
  return coldest;
}

namespace {

/// A condition ends only when the temperature has risen by this much.
constexpr Kelvins kHysteresis{0.5};

std::string describe_cold_reading(const InterlockLimits& limits, const ColdestReading& coldest) {
  return fmt::format(
      "the unit is too cold for the air of the room: {} reads {:.1f} °C; open the door only at {:.1f} °C or more",
      coldest.column < limits.channels.size() ? limits.channels[coldest.column] : "a thermometer", coldest.value.value,
      limits.room->warm_from().value);
}

}  // namespace

std::string describe_cold_unit(const InterlockLimits& limits, const Sample& sample) {
  const auto coldest = find_coldest(limits, sample);
  if (!limits.room || !coldest || coldest->value >= limits.room->warm_from()) return {};
  return describe_cold_reading(limits, *coldest);
}

std::vector<CheckResult> find_condensation(const CheckInputs& in) {
  const auto coldest = find_coldest(in.limits, in.sample);
  if (!coldest || !in.chamber() || !in.chamber()->dew_point) return {};
  const auto wet = condensation_point(*in.chamber()->dew_point);
  const auto hysteresis = in.was_found(InterlockId::condensation) ? kHysteresis : Kelvins{};
  if (coldest->value >= wet + in.limits.condensation_margin + hysteresis) return {};
  return {{.text = fmt::format("condensation on the unit is possible: {} reads {:.1f} °C, the {} point of the chamber "
                               "is {:.1f} °C",
                               in.channel(coldest->column), coldest->value.value, wet < Celsius{0} ? "frost" : "dew",
                               wet.value)}};
}

std::vector<CheckResult> find_cold_unit_at_door(const CheckInputs& in) {
  const bool is_open = in.chamber() && in.chamber()->activity == ChamberActivity::door_open;
  const auto coldest = find_coldest(in.limits, in.sample);
  if (!in.limits.room || !coldest || !(in.facts.door_may_open || is_open)) return {};
  const auto hysteresis = in.was_found(InterlockId::cold_at_door) ? kHysteresis : Kelvins{};
  if (coldest->value >= in.limits.room->warm_from() + hysteresis) return {};
  return {{.text = describe_cold_reading(in.limits, *coldest)}};
}

}  // namespace gyrotherm::interlocks
