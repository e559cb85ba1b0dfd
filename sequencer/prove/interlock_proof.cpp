// SPDX-License-Identifier: Apache-2.0
#include "sequencer/prove/interlock_proof.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <utility>

#include "sequencer/prove/interlock_bench.hpp"

namespace gyrotherm::prove {
namespace {

using interlocks::InterlockId;
using interlocks::InterlockLimits;

/// Seconds without a fault before an injection, seconds beyond an interlock's own times in which it must act, and the
/// longest injection in seconds.
constexpr int kQuietSeconds = 150, kPatience = 4000, kMostSeconds = 40'000;
constexpr double kJustK = 0.5;
/// Time constants of the chamber after which the predicted air has reached a new set point.
constexpr int kLagsUntilFollowed = 8;

auto no_reply() { return failure(FaultKind::timeout, "injected", "no reply"); }

/// One injection. `inject` changes the readings of second `second`, from 1 on.
struct Injection {
  InterlockId id{};
  std::function<void(InterlockBench&, int second)> inject;
  /// Values just inside the limit, which must not act; none if empty.
  std::function<void(InterlockBench&, int second)> inside{};
  /// Returns why this rig has no such interlock; empty: it has.
  std::function<std::string(const rig::RigFile&)> omitted{};
  /// Returns the time that the check itself needs, before the confirmation of the table; none if empty.
  std::function<Duration(const InterlockLimits&)> needs{};
};

/// Returns a deviation just inside a limit: less by `step`, and at least half of the limit.
Kelvins just_inside(Kelvins limit, Kelvins step) { return std::max(limit - step, limit * 0.5); }

/// Returns a change within a second that no air and no solid body can make, with a margin for noise.
Kelvins impossible_change(double fastest_k_per_min) {
  constexpr double kMargin = 1.5;
  return Kelvins{kMargin * fastest_k_per_min / kSecondsPerMinute + kJustK};
}

/// Returns a jump of the chamber's sensor beyond its limit that is too fast for air.
Kelvins chamber_sensor_jump(const InterlockLimits& limits) {
  constexpr double kTimesTheFastest = 3;
  const double fastest = std::max(interlocks::kFastestPlausibleAir.value, kTimesTheFastest * limits.air_fastest.value);
  return std::max(limits.chamber_disagreement + Kelvins{1}, impossible_change(fastest));
}

/// Returns a jump of a thermometer beyond its limit that is too fast for a solid body.
Kelvins thermometer_jump(const InterlockLimits& limits) {
  constexpr double kFastestBody_k_per_min = 15;
  const double fastest = std::max(kFastestBody_k_per_min, limits.thermometers_fastest.value);
  return std::max(limits.drift + Kelvins{kJustK}, impossible_change(fastest));
}

/// Returns the set point of the test of `following`: beyond the band around air that stays at the safe set point, as
/// far as the chamber's limits permit.
Celsius unfollowed_set_point(const rig::RigFile& rig) {
  constexpr Kelvins kUsual{40}, kMore{5};
  constexpr double kBands = 1.25;
  const auto base = rig.safe_set_point;
  const auto off = std::max(kUsual, rig.limits.follow_band * kBands + kMore);
  const auto up = rig.chamber_limits.highest - base, down = base - rig.chamber_limits.lowest;
  return up >= off || up >= down ? base + std::min(off, up) : base - std::min(off, down);
}

/// Returns why the band of `following` cannot be exceeded from the safe set point, although the chamber can exceed it.
std::string following_omitted(const rig::RigFile& rig) {
  const auto& band = rig.limits.follow_band;
  const bool is_reached = abs(unfollowed_set_point(rig) - rig.safe_set_point) > band;
  const bool is_possible = rig.chamber_limits.highest - rig.chamber_limits.lowest > band;
  return is_reached || !is_possible
             ? ""
             : "the band exceeds the distance of the safe set point from the limits of the chamber";
}

void set_activity(InterlockBench& bench, ChamberActivity activity) { bench.chamber().activity = activity; }

/// Changes the air by a rate from the second on; the set point and the thermometers follow.
void ramp_air(InterlockBench& bench, int second, double k_per_min) {
  bench.air = bench.set_point = bench.base() + Kelvins{k_per_min * second / 60};
  bench.chamber().air = bench.air;
  bench.chamber().set_point = bench.set_point;
  bench.inputs.sent = bench.set_point;
}

std::vector<Injection> temperature_injections(const rig::RigFile& rig) {
  const auto air_to = [](double beyond) {
    return [beyond](InterlockBench& b, int) { b.chamber().air = b.limits().air_highest + Kelvins{beyond}; };
  };
  const auto first_to = [](double beyond) {
    return [beyond](InterlockBench& b, int) {
      b.sample.thermometers[0].value = b.own_limits(0).highest + Kelvins{beyond};
    };
  };
  const auto sensor_off = [](bool beyond) {
    return [beyond](InterlockBench& b, int) {
      const auto off =
          beyond ? chamber_sensor_jump(b.limits()) : just_inside(b.limits().chamber_disagreement, Kelvins{1});
      if (b.limits().air_thermometers.empty()) b.chamber().air = b.base() + off;
      for (const auto column : b.limits().air_thermometers) b.sample.thermometers[column].value = b.chamber().air + off;
    };
  };
  const auto air_rate = [](double factor) {
    return [factor](InterlockBench& b, int s) { ramp_air(b, s, factor * b.limits().air_fastest.value); };
  };
  const auto first_rate = [](double factor) {
    return [factor](InterlockBench& b, int s) {
      const double k_per_s = factor * b.limits().thermometers_fastest.value / 60;
      b.sample.thermometers[0].value = b.thermometer_base(0) + Kelvins{k_per_s * s};
    };
  };
  const auto first_off = [](auto distance) {
    return [distance](InterlockBench& b, int) {
      b.sample.thermometers[0].value = b.thermometer_base(0) + distance(b.limits());
    };
  };
  const auto needs_three = [](const rig::RigFile& rig) {
    return rig.limits.channels.size() < 3 ? "the rig has fewer than three thermometers" : "";
  };
  return {
      {InterlockId::air_limit, air_to(kJustK), air_to(-kJustK)},
      {InterlockId::thermometer_limit, first_to(kJustK), first_to(-kJustK)},
      {InterlockId::chamber_sensor, sensor_off(true), sensor_off(false)},
      {InterlockId::air_rate, air_rate(1.1), air_rate(0.9)},
      {InterlockId::thermometer_rate, first_rate(1.1), first_rate(0.9)},
      {InterlockId::following,
       [set_point = unfollowed_set_point(rig)](InterlockBench& b, int) {
         b.chamber().set_point = set_point;
         b.inputs.sent = set_point;
       },
       {},
       following_omitted,
       [](const InterlockLimits& limits) { return limits.chamber_lag * kLagsUntilFollowed; }},
      {InterlockId::disagreement, first_off([](const auto& limits) { return limits.disagreement + Kelvins{1}; }),
       first_off([](const auto& limits) { return just_inside(limits.disagreement, Kelvins{1}); }), needs_three},
      {InterlockId::stuck,
       [](InterlockBench& b, int s) {
         for (std::size_t i = 1; i < b.sample.thermometers.size(); ++i)
           b.sample.thermometers[i].value = b.thermometer_base(i) + Kelvins{0.01 * s};
         b.sample.thermometers[0].value = b.thermometer_base(0);
       },
       {},
       needs_three},
      {InterlockId::drifting, first_off(thermometer_jump),
       first_off([](const auto& limits) { return just_inside(limits.drift, Kelvins{kJustK}); }), needs_three},
  };
}

/// Returns the coldest and the hottest thermometer of a bench without a fault.
std::pair<Celsius, Celsius> thermometer_range(const InterlockBench& bench) {
  std::pair range(bench.thermometer_base(0), bench.thermometer_base(0));
  for (std::size_t i = 1; i < bench.limits().channels.size(); ++i) {
    range.first = std::min(range.first, bench.thermometer_base(i));
    range.second = std::max(range.second, bench.thermometer_base(i));
  }
  return range;
}

std::vector<Injection> response_injections(const rig::RigFile&) {
  return {
      {InterlockId::no_thermal_response,
       [](InterlockBench& b, int) {
         const auto moved = b.base() + b.limits().response_step + Kelvins{2};
         b.chamber().air = b.chamber().set_point = moved;
         b.inputs.sent = moved;
       }},
      {InterlockId::condensation,
       [](InterlockBench& b, int) { b.chamber().dew_point = thermometer_range(b).second + Kelvins{1}; },
       [](InterlockBench& b, int) {
         b.chamber().dew_point = thermometer_range(b).first - b.limits().condensation_margin - Kelvins{20};
       },
       [](const rig::RigFile& rig) { return records_dew_point(rig) ? "" : "the rig records no dew point"; }},
      {InterlockId::cold_at_door,
       [](InterlockBench& b, int) {
         b.inputs.door_may_open = true;
         for (auto& reading : b.sample.thermometers) reading.value = b.limits().room->warm_from() - Kelvins{1};
       },
       [](InterlockBench& b, int) {
         b.inputs.door_may_open = true;
         for (auto& reading : b.sample.thermometers) reading.value = b.limits().room->warm_from() + Kelvins{1};
       },
       [](const rig::RigFile& rig) { return rig.limits.room ? "" : "the rig has no room air"; }},
  };
}

std::vector<Injection> silence_injections(const rig::RigFile&) {
  const auto has_unneeded = [](const rig::RigFile& rig) {
    const auto continues = std::ranges::count(rig.limits.units, true, &interlocks::UnitLimits::continue_when_silent);
    return continues == 0 || rig.limits.units.size() < 2 ? "no unit may be silent while others send" : "";
  };
  return {
      {InterlockId::chamber_silent, [](InterlockBench& b, int) { b.sample.chamber.value = no_reply(); }},
      {InterlockId::thermometers_lost,
       [](InterlockBench& b, int) {
         for (auto& reading : b.sample.thermometers) reading.value = no_reply();
       }},
      {InterlockId::needed_channel_lost,
       [](InterlockBench& b, int) {
         for (const auto& unit : b.limits().units)
           if (!unit.thermometers.empty()) b.sample.thermometers[unit.thermometers.front()].value = no_reply();
       },
       {},
       [](const rig::RigFile& rig) {
         const bool any = std::ranges::any_of(rig.limits.units, [](const auto& u) { return !u.thermometers.empty(); });
         return any ? "" : "the analysis needs no thermometer";
       }},
      {InterlockId::gyro_silent,
       [](InterlockBench& b, int) {
         for (auto& unit : b.sample.units) unit.count.value = no_reply();
       }},
      {InterlockId::unit_silent,
       [](InterlockBench& b, int) {
         for (std::size_t i = 0; i < b.sample.units.size(); ++i)
           if (b.limits().units[i].continue_when_silent) return void(b.sample.units[i].count.value = no_reply());
       },
       {},
       has_unneeded},
      {InterlockId::channel_lost, [](InterlockBench& b, int) { b.sample.thermometers[0].value = no_reply(); }},
      {InterlockId::frozen,
       [](InterlockBench& b, int) {
         b.is_frozen = true;
         const auto& first = b.limits().instruments.front().columns;
         for (const auto column : first) b.sample.thermometers[column].value = b.thermometer_base(column);
       },
       {},
       {},
       [](const InterlockLimits& limits) { return limits.frozen_after; }},
      {InterlockId::gyro_dead,
       [](InterlockBench& b, int) {
         b.is_dead = true;
         for (auto& unit : b.sample.units)
           if (unit.count.value) std::ranges::fill(unit.count.value->pulses, 0);
       },
       {},
       {},
       [](const InterlockLimits& limits) { return limits.gyro_dead_after; }},
  };
}

std::vector<Injection> chamber_injections(const rig::RigFile&) {
  const auto active = [](ChamberActivity activity) {
    return [activity](InterlockBench& b, int) { set_activity(b, activity); };
  };
  /// The chamber is silent for three seconds and then differs.
  const auto restart = [](auto change) {
    return [change](InterlockBench& b, int s) {
      if (s <= 3) return void(b.sample.chamber.value = no_reply());
      change(b);
    };
  };
  return {
      {InterlockId::chamber_alarm,
       [](InterlockBench& b, int) {
         b.chamber().must_stop = true;
         b.chamber().alarms = {"injected"};
       }},
      {InterlockId::emergency_stop, active(ChamberActivity::emergency_stop)},
      {InterlockId::door, active(ChamberActivity::door_open)},
      {InterlockId::supply, active(ChamberActivity::power_failure)},
      {InterlockId::not_following, active(ChamberActivity::not_following)},
      {InterlockId::foreign_set_point,
       [](InterlockBench& b, int) {
         b.chamber().set_point = *b.inputs.sent + b.inputs.set_point_tolerance + Kelvins{1};
       },
       [](InterlockBench& b, int) { b.chamber().set_point = *b.inputs.sent + b.inputs.set_point_tolerance * 0.5; }},
      {InterlockId::restarted, restart([](InterlockBench& b) { b.chamber().set_point = b.base() + Kelvins{10}; })},
      {InterlockId::restarted_off, restart([](InterlockBench& b) { set_activity(b, ChamberActivity::off); })},
      {InterlockId::not_taken, [](InterlockBench& b, int) { b.inputs.refusals = 3; },
       [](InterlockBench& b, int) { b.inputs.refusals = 2; }},
  };
}

std::vector<Injection> program_injections(const rig::RigFile&) {
  const auto powered = [](const rig::RigFile& rig) {
    return rig.supplies.empty() ? "the rig has no power supply" : "";
  };
  const auto power = [](std::vector<interlocks::PowerFault> interlocks::PowerFaults::*list) {
    return [list](InterlockBench& b, int) { b.inputs.power.*list = {{"supply 1, output 1", "injected"}}; };
  };
  const auto missed = [](Duration more) {
    return [more](InterlockBench& b, int second) {
      b.inputs.missed = second == 1 ? b.inputs.longest_missed + more : Duration{};
      b.elapsed = second == 1 ? b.inputs.missed + kSecond : kSecond;
    };
  };
  return {
      {InterlockId::deadline, [](InterlockBench& b, int) { b.sample.progress.phase = Phase::overdue; }},
      {InterlockId::program, [](InterlockBench& b, int) { b.inputs.program = "injected"; }},
      {InterlockId::power_limit, power(&interlocks::PowerFaults::outside), {}, powered},
      {InterlockId::power_trip, power(&interlocks::PowerFaults::tripped), {}, powered},
      {InterlockId::power_changed, power(&interlocks::PowerFaults::changed), {}, powered},
      {InterlockId::power_not_switched, power(&interlocks::PowerFaults::not_switched), {}, powered},
      {InterlockId::another_instrument,
       [](InterlockBench& b, int) { b.inputs.mismatched_instruments = {"chamber: injected"}; }},
      {InterlockId::slept, missed(kSecond), missed({})},
      {InterlockId::storage, [](InterlockBench& b, int) { b.inputs.backlog = b.limits().backlog + kSecond; },
       [](InterlockBench& b, int) { b.inputs.backlog = b.limits().backlog; }},
      {InterlockId::record_damaged, [](InterlockBench& b, int) { b.inputs.record_damage = "injected"; }},
      {InterlockId::unguarded,
       [](InterlockBench& b, int) {
         b.inputs.guard_troubles = {{"guard", "injected"}};
       }},
      {InterlockId::wall_clock,
       [](InterlockBench& b, int second) {
         if (second == 1) b.sample.at.utc += std::chrono::milliseconds(60);
       },
       [](InterlockBench& b, int second) {
         if (second == 1) b.sample.at.utc += std::chrono::milliseconds(40);
       }},
  };
}

std::vector<Injection> all_injections(const rig::RigFile& rig) {
  std::vector<Injection> all;
  for (auto* list :
       {&temperature_injections, &response_injections, &silence_injections, &chamber_injections, &program_injections})
    for (auto& one : list(rig)) all.push_back(std::move(one));
  return all;
}

/// Lets seconds pass until the interlock acts. Returns its alarm and the number of seconds, or nothing.
struct Acted {
  int seconds{};
  interlocks::Reaction reaction{};
};
std::optional<Acted> run_until(InterlockBench& bench, InterlockId id, int seconds,
                               const std::function<void(InterlockBench&, int)>& inject) {
  for (int second = 1; second <= seconds; ++second) {
    bench.fill();
    if (inject) inject(bench, second);
    for (const auto& alarm : bench.judge())
      if (alarm.id == id) return Acted{second, alarm.reaction};
  }
  return std::nullopt;
}

/// The times of one interlock in seconds.
struct ActingTimes {
  /// Fewest seconds of the cause after which it may act.
  std::int64_t least{};
  /// Seconds of the cause that its own check needs before.
  std::int64_t needed{};
  [[nodiscard]] std::int64_t all() const { return least + needed; }
};

ActingTimes find_times(const InterlockLimits& limits, const interlocks::Interlock& row, const Injection& injection) {
  const auto& needs = row.confirmation;
  const auto after = needs.after_limit != nullptr ? limits.*needs.after_limit : needs.after;
  const int samples = needs.samples_limit != nullptr ? limits.*needs.samples_limit : needs.samples;
  return {.least = std::max<std::int64_t>(samples, after / kSecond),
          .needed = injection.needs ? injection.needs(limits) / kSecond : 0};
}

InterlockBench begin_bench(const rig::RigFile& rig) {
  InterlockBench bench(rig.limits, rig.safe_set_point);
  bench.begin();
  return bench;
}

InterlockOutcome inject(const rig::RigFile& rig, const Injection& injection) {
  const auto id = injection.id;
  InterlockOutcome outcome{.id = id};
  if (injection.omitted) outcome.omitted = injection.omitted(rig);
  if (!outcome.omitted.empty()) return outcome;
  const auto& row = interlocks::interlock(id);
  const auto times = find_times(rig.limits, row, injection);
  if (times.all() > kMostSeconds - kPatience) {
    outcome.omitted =
        fmt::format("it acts only after {}, longer than its test", format_duration(std::chrono::seconds(times.all())));
    return outcome;
  }
  auto bench = begin_bench(rig);
  if (run_until(bench, id, kQuietSeconds, {})) return outcome.cause = "acts on readings without a fault", outcome;
  const int least = static_cast<int>(times.least);
  if (injection.inside) {
    auto inside = bench;
    if (const auto acted = run_until(inside, id, std::min(2 * least + kQuietSeconds, kMostSeconds), injection.inside))
      return outcome.cause = fmt::format("acts after {} s on values inside its limit", acted->seconds), outcome;
  }
  const auto acted =
      run_until(bench, id, std::min(kPatience + 2 * static_cast<int>(times.all()), kMostSeconds), injection.inject);
  if (!acted) return outcome.cause = "does not act on injected values", outcome;
  outcome.seconds = acted->seconds;
  outcome.reaction = acted->reaction;
  const auto demanded = rig.limits.policy[static_cast<std::size_t>(id)];
  if (acted->seconds < least)
    outcome.cause = fmt::format("acts after {} s, before its {} s", acted->seconds, least);
  else if (acted->reaction != demanded && acted->reaction != interlocks::Reaction::abort)
    outcome.cause = fmt::format("reacts by {}, expected {}", name(acted->reaction), name(demanded));
  return outcome;
}

}  // namespace

std::vector<InterlockOutcome> inject_all(const rig::RigFile& rig) {
  std::vector<InterlockOutcome> outcomes;
  for (const auto& injection : all_injections(rig)) outcomes.push_back(inject(rig, injection));
  std::ranges::sort(outcomes, {}, &InterlockOutcome::id);
  return outcomes;
}

ProofResult prove_interlocks(const rig::RigFile& rig, const DrillEnvironment& environment) {
  DrillLog log(ProofTest::interlocks, environment);
  log.limit("each interlock acts on injected values", "with the reaction of the rig file");
  log.limit("no interlock acts", fmt::format("in {} s without a fault, or inside its limit", kQuietSeconds));
  std::string causes;
  for (const auto& outcome : inject_all(rig)) {
    const auto* interlock = interlocks::name(outcome.id);
    if (!outcome.omitted.empty())
      log.read(interlock, "not tested: " + outcome.omitted);
    else if (!outcome.cause.empty())
      log.read(interlock, "FAILED: " + outcome.cause);
    else
      log.read(interlock, fmt::format("{} after {} s", name(outcome.reaction), outcome.seconds));
    if (!outcome.cause.empty()) causes += fmt::format("{}{} {}", causes.empty() ? "" : "; ", interlock, outcome.cause);
  }
  return log.end(causes.empty() ? ProofVerdict::passed : ProofVerdict::failed, causes);
}

}  // namespace gyrotherm::prove
