#include "rig/interlocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace gyrotherm {
namespace {

Duration silence(Duration before, bool answered, Duration elapsed) { return answered ? Duration{} : before + elapsed; }

/// The first limit that the sample is beyond, in words, or nothing.
std::string beyond(const InterlockLimits& limits, const Sample& sample) {
  if (sample.chamber.value) {
    const auto air = sample.chamber.value->air;
    if (air < limits.air_lowest || air > limits.air_highest)
      return fmt::format("chamber air {:.2f} °C is outside {:g} … {:g} °C", air.value, limits.air_lowest.value,
                         limits.air_highest.value);
  }
  for (const auto& reading : sample.thermometers)
    if (reading.value && (*reading.value < limits.thermometers_lowest || *reading.value > limits.thermometers_highest))
      return fmt::format("a thermometer reads {:.2f} °C, outside {:g} … {:g} °C", reading.value->value,
                         limits.thermometers_lowest.value, limits.thermometers_highest.value);
  return {};
}

/// What the chamber itself asks for: its stopping alarms end a run, an open door or a lost supply suspends it.
Verdict chamber_asks(const ChamberState& chamber) {
  if (chamber.must_stop)
    return {Reaction::abort,
            fmt::format("chamber alarm: {}", chamber.alarms.empty() ? "unnamed" : chamber.alarms.front())};
  switch (chamber.activity) {
    case ChamberActivity::emergency_stop: return {Reaction::abort, "the chamber's emergency stop is pressed"};
    case ChamberActivity::door_open: return {Reaction::suspend, "the chamber's door is open"};
    case ChamberActivity::power_failure: return {Reaction::suspend, "the chamber has lost its supply"};
    default: return {};
  }
}

/// The milder or harder reaction to one instrument's silence.
Verdict about(const char* instrument, Duration silent, Duration suspend_after, Duration lost) {
  if (silent >= lost) return {Reaction::abort, fmt::format("{} silent for {}", instrument, spoken(silent))};
  if (silent >= suspend_after) return {Reaction::suspend, fmt::format("{} silent for {}", instrument, spoken(silent))};
  return {};
}

}  // namespace

Judgement judge(const InterlockLimits& limits, const InterlockMemory& memory, const Sample& sample, Duration elapsed) {
  const bool any_thermometer = std::any_of(sample.thermometers.begin(), sample.thermometers.end(),
                                           [](const auto& reading) { return reading.value.has_value(); });
  const auto outside = beyond(limits, sample);
  const InterlockMemory now{
      .chamber_silent = silence(memory.chamber_silent, sample.chamber.value.has_value(), elapsed),
      .thermometers_silent =
          silence(memory.thermometers_silent, any_thermometer || sample.thermometers.empty(), elapsed),
      .gyro_silent = silence(memory.gyro_silent, sample.gyro.value.has_value(), elapsed),
      .beyond_limit = outside.empty() ? 0 : memory.beyond_limit + 1,
  };
  Verdict worst;
  for (auto& verdict :
       {about("chamber", now.chamber_silent, limits.suspend_after, limits.chamber_lost),
        about("every thermometer", now.thermometers_silent, limits.suspend_after, limits.thermometers_lost),
        about("gyro", now.gyro_silent, limits.suspend_after, limits.gyro_lost)})
    if (verdict.reaction > worst.reaction) worst = verdict;
  if (sample.chamber.value)
    if (auto asked = chamber_asks(*sample.chamber.value); asked.reaction > worst.reaction) worst = std::move(asked);
  if (now.beyond_limit >= limits.confirming_samples) worst = {Reaction::abort, outside};
  if (sample.progress.phase == Phase::overdue)
    worst = {Reaction::abort, fmt::format("segment {} passed its deadline", sample.progress.segment + 1)};
  return {worst, now};
}

}  // namespace gyrotherm
