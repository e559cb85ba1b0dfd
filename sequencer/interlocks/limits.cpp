// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/limits.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sequencer/interlocks/interlocks.hpp"

namespace gyrotherm::interlocks {
namespace {

/// Reads a time above zero. A limit of zero would be exceeded in every sample.
Duration read_time(const TomlTable& table, std::string_view key, Duration fallback) {
  const auto time = table.duration(key, fallback);
  if (time <= Duration{}) table.note_error(key, "expected a time longer than zero");
  return time;
}

Kelvins read_band(const TomlTable& table, std::string_view key, Kelvins fallback) {
  const auto band = table.kelvins(key, fallback);
  if (!(band > Kelvins{0})) table.note_error(key, "expected more than 0 K");
  return band;
}

void read_range(const TomlTable& table, const std::string& prefix, Celsius& lowest, Celsius& highest) {
  lowest = table.celsius(prefix + "lowest", lowest);
  highest = table.celsius(prefix + "highest", highest);
  if (!(lowest < highest)) table.note_error(prefix + "lowest", "the lowest temperature is not below the highest");
}

/// Reads the silence that ends a run. It must not be shorter than the silence that suspends it.
Duration read_lost(const TomlTable& table, std::string_view key, Duration fallback, Duration suspend_after) {
  const auto time = read_time(table, key, fallback);
  if (time > Duration{} && time < suspend_after)
    table.note_error(table.has(key) ? key : "suspend_after",
                     fmt::format("{} is {}, expected suspend_after, {}, or more", key, format_duration(time),
                                 format_duration(suspend_after)));
  return time;
}

void read_times(const TomlTable& table, InterlockLimits& limits) {
  limits.suspend_after = read_time(table, "suspend_after", limits.suspend_after);
  limits.chamber_lost = read_lost(table, "chamber_lost", limits.chamber_lost, limits.suspend_after);
  limits.thermometers_lost = read_lost(table, "thermometers_lost", limits.thermometers_lost, limits.suspend_after);
  limits.gyro_lost = read_lost(table, "gyro_lost", limits.gyro_lost, limits.suspend_after);
  limits.chamber_lag = read_time(table, "chamber_lag", limits.chamber_lag);
  limits.follow_time = read_time(table, "follow_time", limits.follow_time);
  limits.backlog = read_time(table, "backlog", limits.backlog);
  limits.clear_after = read_time(table, "clear_after", limits.clear_after);
}

void read_measurements(const TomlTable& table, InterlockLimits& limits) {
  limits.frozen_after = read_time(table, "frozen_after", limits.frozen_after);
  limits.gyro_dead_after = read_time(table, "gyro_dead_after", limits.gyro_dead_after);
  if (table.has("gyro_band")) {
    limits.gyro_band = DegreesPerHour{table.number("gyro_band")};
    if (!(limits.gyro_band->value > 0)) table.note_error("gyro_band", "expected more than 0 °/h");
  }
  limits.response_step = read_band(table, "response_step", limits.response_step);
  limits.response_time = read_time(table, "response_time", limits.response_time);
  limits.drift = read_band(table, "drift", limits.drift);
  limits.condensation_margin = table.kelvins("condensation_margin", limits.condensation_margin);
  if (limits.condensation_margin < Kelvins{0}) table.note_error("condensation_margin", "expected 0 K or more");
}

std::size_t find_column(const std::vector<std::string>& channels, const std::string& name) {
  return static_cast<std::size_t>(std::find(channels.begin(), channels.end(), name) - channels.begin());
}

/// Reads [limits.channel.NAME].
void read_own_limits(const TomlTable& table, InterlockLimits& limits) {
  const auto own = table.table("channel");
  const auto named = own.keys();
  if (named.empty()) return;
  limits.thermometers.assign(limits.channels.size(), {limits.thermometers_lowest, limits.thermometers_highest});
  for (const auto& name : named) {
    const auto column = find_column(limits.channels, name);
    const auto its = own.table(name);
    if (column == limits.channels.size()) {
      own.note_error(name, fmt::format("\"{}\" is not a channel of this rig's thermometers", name));
      (void)its.keys();
      continue;
    }
    read_range(its, "", limits.thermometers[column].lowest, limits.thermometers[column].highest);
  }
}

void read_air_thermometers(const TomlTable& table, InterlockLimits& limits) {
  for (const auto& name : table.texts("air_thermometers")) {
    const auto column = find_column(limits.channels, name);
    if (column == limits.channels.size())
      table.note_error("air_thermometers", fmt::format("\"{}\" is not a channel of this rig's thermometers", name));
    else
      limits.air_thermometers.push_back(column);
  }
}

Reaction parse_reaction(const std::string& keyword) {
  for (const auto reaction : {Reaction::warn, Reaction::suspend, Reaction::hold, Reaction::abort})
    if (keyword == name(reaction)) return reaction;
  return Reaction::abort;
}

void read_policy(const TomlTable& table, Policy& policy) {
  for (std::size_t i = 0; i < kInterlocks; ++i) {
    const auto& row = interlock(static_cast<InterlockId>(i));
    if (!table.has(row.name)) continue;
    const auto keyword = table.choice(row.name, {"warn", "suspend", "hold", "abort"});
    if (!row.choosable && keyword != "abort")
      table.note_error(row.name, "this always ends the run, expected \"abort\"");
    policy[i] = parse_reaction(keyword);
  }
  const auto of = [&](InterlockId id) -> Reaction& { return policy[static_cast<std::size_t>(id)]; };
  const bool has_only_restarted = table.has("restarted") && !table.has("restarted_off");
  if (has_only_restarted) of(InterlockId::restarted_off) = of(InterlockId::restarted);
}

}  // namespace

InterlockLimits read_limits(const TomlTable& root, const std::vector<std::string>& channels,
                            const profile::ChamberLimits& chamber) {
  // Ratio of air_fastest to the chamber's fastest rate.
  constexpr double kMuchFaster = 2.5;
  InterlockLimits limits;
  limits.channels = channels;
  const auto fastest = std::max(chamber.fastest_heating.value, chamber.fastest_cooling.value);
  limits.air_fastest.value = std::max(limits.air_fastest.value, kMuchFaster * fastest);
  const auto table = root.table("limits");
  read_range(table, "air_", limits.air_lowest, limits.air_highest);
  read_range(table, "thermometers_", limits.thermometers_lowest, limits.thermometers_highest);
  const auto confirming = table.integer("confirming_samples", limits.confirming_samples);
  limits.confirming_samples = bounded<int>(table, "confirming_samples", confirming, 1, 3600);
  const auto needed = table.integer("thermometers_needed", limits.thermometers_needed);
  limits.thermometers_needed =
      bounded<int>(table, "thermometers_needed", needed, 1, std::max<int>(1, static_cast<int>(channels.size())));
  limits.air_fastest = table.positive_rate("air_fastest", limits.air_fastest);
  limits.thermometers_fastest = table.positive_rate("thermometers_fastest", limits.thermometers_fastest);
  limits.disagreement = read_band(table, "disagreement", limits.disagreement);
  limits.chamber_disagreement = read_band(table, "chamber_disagreement", limits.chamber_disagreement);
  limits.follow_band = read_band(table, "follow_band", limits.follow_band);
  read_times(table, limits);
  read_measurements(table, limits);
  read_own_limits(table, limits);
  read_air_thermometers(table, limits);
  read_policy(root.table("policy"), limits.policy);
  return limits;
}

RunLimits read_run_limits(const TomlTable& root) {
  RunLimits limits;
  const auto table = root.table("limits");
  limits.longest_suspended = read_time(table, "longest_suspended", limits.longest_suspended);
  limits.longest_held = read_time(table, "longest_held", limits.longest_held);
  limits.longest_return = read_time(table, "longest_return", limits.longest_return);
  limits.resume_delay = read_time(table, "resume_delay", limits.resume_delay);
  const auto safe = root.table("safe");
  const auto on_stop = safe.choice("on_stop", {"safe", "hold"}, "safe");
  limits.on_stop = on_stop == "hold" ? OnStop::hold : OnStop::safe;
  const auto on_hangup = safe.choice("on_hangup", {"go_on", "safe"}, "go_on");
  limits.on_hangup = on_hangup == "safe" ? OnHangup::safe : OnHangup::go_on;
  return limits;
}

}  // namespace gyrotherm::interlocks
