// SPDX-License-Identifier: Apache-2.0
#include "sequencer/interlocks/interlocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sequencer/interlocks/measurement_checks.hpp"

namespace gyrotherm::interlocks {

namespace {

using std::chrono::seconds;
using Found = std::vector<CheckResult>;  ///< one result per subject

constexpr int kStuckSamples = 120;
constexpr Kelvins kMinChangeOfOthers{0.5};
constexpr Duration kWallStep = std::chrono::milliseconds(50);
constexpr int kRefusals = 3;
constexpr Kelvins kNearLimit{2};

Found make_result(std::string text) { return {CheckResult{.text = std::move(text)}}; }

std::optional<Celsius> median_reading(const Sample& sample, const std::vector<std::size_t>& columns) {
  Sample few;
  for (const auto column : columns) few.thermometers.push_back(sample.thermometers[column]);
  return Ranks(few).median();
}

// ---- temperatures ---------------------------------------------------------------------------------------------------

Found check_air_limit(const CheckInputs& in) {
  if (!in.chamber()) return {};
  const auto air = in.chamber()->air;
  if (air >= in.limits.air_lowest && air <= in.limits.air_highest) return {};
  return make_result(fmt::format("chamber air {:.2f} °C is outside {:g} … {:g} °C", air.value,
                                 in.limits.air_lowest.value, in.limits.air_highest.value));
}

Found check_thermometer_limit(const CheckInputs& in) {
  Found outside;
  for (std::size_t i = 0; i < in.sample.thermometers.size(); ++i) {
    const auto value = known_value(in.sample.thermometers[i]);
    const auto own = i < in.limits.thermometers.size()
                         ? in.limits.thermometers[i]
                         : ThermometerLimits{in.limits.thermometers_lowest, in.limits.thermometers_highest};
    if (!value || (*value >= own.lowest && *value <= own.highest)) continue;
    outside.push_back(in.thermometer_result(i, fmt::format("{} reads {:.2f} °C, outside {:g} … {:g} °C", in.channel(i),
                                                           value->value, own.lowest.value, own.highest.value)));
  }
  return outside;
}

/// Compares the chamber's own sensor with the thermometers in the air. Without such thermometers, checks the sensor for
/// jumps.
Found check_chamber_sensor(const CheckInputs& in) {
  if (!in.chamber()) return {};
  const auto air = in.chamber()->air;
  if (in.limits.air_thermometers.empty()) {
    if (!(abs(in.memory.air_jump_sum) > in.limits.chamber_disagreement)) return {};
    return make_result(fmt::format("the chamber's sensor jumped by {:+.1f} K, too fast for air: {:.1f} °C",
                                   in.memory.air_jump_sum.value, air.value));
  }
  const auto others = median_reading(in.sample, in.limits.air_thermometers);
  if (!others || abs(air - *others) <= in.limits.chamber_disagreement) return {};
  return make_result(
      fmt::format("the chamber's sensor reads {:.1f} °C, the thermometers {:.1f} °C", air.value, others->value));
}

Found check_air_rate(const CheckInputs& in) {
  const auto rate = in.memory.air.rate();
  if (!rate || std::abs(rate->value) <= in.limits.air_fastest.value) return {};
  return make_result(fmt::format("the chamber's air changes by {:.1f} °C in a minute", rate->value));
}

Found check_thermometer_rate(const CheckInputs& in) {
  Found fast;
  for (std::size_t i = 0; i < in.memory.thermometers.size(); ++i)
    if (const auto rate = in.memory.thermometers[i].rate();
        rate && std::abs(rate->value) > in.limits.thermometers_fastest.value)
      fast.push_back(
          in.thermometer_result(i, fmt::format("{} changes by {:.1f} °C in a minute", in.channel(i), rate->value)));
  return fast;
}

/// Compares the air with its prediction, a first-order lag behind the set point. Permits three times the predicted lag.
/// In the first minutes the air must also stay in the range that the set points explain.
Found check_following(const CheckInputs& in) {
  if (!in.chamber() || !in.memory.expected || !in.memory.set_point) return {};
  const auto air = in.chamber()->air;
  const auto band = std::max(in.limits.follow_band, in.memory.lag * 3);
  auto found = find_unexplained_air(in);
  if (abs(air - *in.memory.expected) <= band) return found;
  const bool near_a_limit = air < in.limits.air_lowest + kNearLimit || air > in.limits.air_highest - kNearLimit;
  found.push_back({.text = fmt::format("the air does not follow the set point: {:.1f} °C, expected {:.1f} °C",
                                       air.value, in.memory.expected->value),
                   .grave = near_a_limit});
  return found;
}

/// Returns the distance of a reading from the range between the other thermometers and the chamber's air; 0 inside the
/// range. Every part of the unit is in that range while heat flows through the unit.
Kelvins distance_from_range(const CheckInputs& in, Celsius value, Celsius others) {
  const auto air = in.chamber() ? in.chamber()->air : others;
  const auto [lowest, highest] = std::minmax(air, others);
  return std::max({Kelvins{}, lowest - value, value - highest});
}

/// Finds the thermometer that is farthest from the range between the air and the median of the others. Ignores those
/// that are already in `found`.
std::optional<CheckResult> find_farthest_thermometer(const CheckInputs& in, const Found& found) {
  Sample left = in.sample;
  for (const auto& one : found) left.thermometers[*one.column].value = failure(FaultKind::out_of_range, "", "");
  const Ranks ranks(left);
  std::optional<CheckResult> farthest;
  Kelvins outside = in.limits.disagreement;
  for (std::size_t i = 0; i < left.thermometers.size(); ++i) {
    const auto value = known_value(left.thermometers[i]);
    const auto others = ranks.median_without(value);
    if (!value || !others) continue;
    const auto distance = distance_from_range(in, *value, *others);
    if (distance <= outside) continue;
    outside = distance;
    farthest = in.thermometer_result(
        i, fmt::format("{} reads {:.1f} °C, the others {:.1f} °C", in.channel(i), value->value, others->value));
  }
  return farthest;
}

/// Finds the thermometers that disagree. A wrong reading shifts the median, so each search excludes the thermometers
/// already found.
Found check_disagreement(const CheckInputs& in) {
  Found all;
  while (auto one = find_farthest_thermometer(in, all)) all.push_back(std::move(*one));
  return all;
}

Found check_stuck(const CheckInputs& in) {
  Found all;
  for (std::size_t i = 0; i < in.sample.thermometers.size(); ++i) {
    const auto value = known_value(in.sample.thermometers[i]);
    if (!value || !in.ranks.median_without(value)) continue;
    const auto& trend = in.memory.thermometers[i];
    if (trend.unchanged_samples() >= kStuckSamples && trend.others_moved() > kMinChangeOfOthers)
      all.push_back(in.thermometer_result(
          i, fmt::format("{} stays at {:.3f} °C while the others change", in.channel(i), value->value)));
  }
  return all;
}

// ---- silence --------------------------------------------------------------------------------------------------------

/// Finds a chamber without a reading. States the reason if the chamber answers, but not as its description requires.
Found check_chamber_silent(const CheckInputs& in) {
  if (in.chamber()) return {};
  const auto& fault = in.sample.chamber.value.error();
  if (means_no_answer(fault)) return {{.text = "chamber silent", .detail = received_text(fault.what)}};
  return make_result(fmt::format("no reading of the chamber ({})", text(fault)));
}
/// The silent units, and the number of units that should send. A unit that is counted as dead belongs to neither.
struct SilentUnits {
  std::vector<std::size_t> silent;
  std::size_t all{};
};

SilentUnits find_silent_units(const CheckInputs& in) {
  SilentUnits units;
  for (std::size_t i = 0; i < in.sample.units.size() && !in.facts.gyro_is_off; ++i) {
    if (in.is_dropped(i) || in.is_dead(i)) continue;
    ++units.all;
    if (!in.sample.units[i].count.value) units.silent.push_back(i);
  }
  return units;
}

/// Describes units without a count: "gyro silent", or "gyro u1 silent" if there are several units. States the reason if
/// a unit sends, but not as its stream requires.
Found describe_silent_units(const CheckInputs& in, const std::vector<std::size_t>& units) {
  const bool is_only_one = in.sample.units.size() < 2;
  Found all;
  for (const auto unit : units) {
    const auto gyro = is_only_one ? std::string("gyro") : "gyro " + in.unit(unit);
    const auto& fault = in.sample.units[unit].count.value.error();
    all.push_back(
        {.text = means_no_answer(fault) ? gyro + " silent" : fmt::format("{} unreadable ({})", gyro, fault.what),
         .subject = in.unit(unit)});
  }
  return all;
}

/// Finds the silent units without which the run cannot continue. If every unit is silent, returns all of them.
Found check_gyro_silent(const CheckInputs& in) {
  auto units = find_silent_units(in);
  if (units.silent.size() == units.all) return describe_silent_units(in, units.silent);
  std::erase_if(units.silent, [&](std::size_t unit) { return in.continues_without(unit); });
  return describe_silent_units(in, units.silent);
}

/// Finds the silent units without which the run continues.
Found check_unit_silent(const CheckInputs& in) {
  auto units = find_silent_units(in);
  if (units.silent.size() == units.all) return {};
  std::erase_if(units.silent, [&](std::size_t unit) { return !in.continues_without(unit); });
  return describe_silent_units(in, units.silent);
}

Found check_thermometers_lost(const CheckInputs& in) {
  const auto& all = in.sample.thermometers;
  const auto answer = std::ranges::count_if(all, [](const auto& reading) { return reading.value.has_value(); });
  const auto needed = std::min<std::ptrdiff_t>(in.limits.thermometers_needed, std::ssize(all));
  if (answer >= needed) return {};
  if (answer > 0) return make_result(fmt::format("{} thermometers answer, {} are needed", answer, needed));
  const auto invalid =
      std::ranges::find_if(all, [](const auto& reading) { return !means_no_answer(reading.value.error()); });
  if (invalid != all.end())
    return make_result(fmt::format("no valid reading of any thermometer ({})", text(invalid->value.error())));
  const auto late = std::ranges::find_if(all, [](const auto& reading) { return is_still_busy(reading.value.error()); });
  return make_result(late == all.end() ? "every thermometer silent"
                                       : fmt::format("every thermometer silent or too slow: {}; a reading must take "
                                                     "less than a second",
                                                     late->value.error().what));
}

/// Finds the unread thermometers among those that `counts` accepts. If all such thermometers of one instrument are
/// unread, and there are several, the instrument is the subject. A channel that was lost earlier than its instrument
/// remains a separate subject.
Found find_lost_thermometers(const CheckInputs& in, InterlockId id, auto counts, const char* why) {
  const auto is_lost = [&](std::size_t i) { return counts(i) && !in.sample.thermometers[i].value; };
  constexpr std::size_t kMostNamed = 3;
  const auto text = [&](const std::vector<std::string>& lost) {
    return fmt::format("no reading of {}{}", fmt::join(lost, ", "), why);
  };
  Found all;
  std::vector<bool> is_reported(in.sample.thermometers.size());
  for (const auto& instrument : in.limits.instruments) {
    std::vector<std::string> lost;
    const auto counted = std::ranges::count_if(instrument.columns, counts);
    for (const auto i : instrument.columns)
      if (is_lost(i)) lost.push_back(in.channel(i));
    if (lost.size() < 2 || std::ssize(lost) < counted) continue;
    auto words = lost.size() <= kMostNamed
                     ? text(lost)
                     : fmt::format("no reading of the {} channels of {}{}", lost.size(), instrument.name, why);
    all.push_back({.text = std::move(words), .subject = instrument.name});
    for (const auto i : instrument.columns) is_reported[i] = !in.memory.is_cause_present(id, in.subject(i));
  }
  for (std::size_t i = 0; i < is_reported.size(); ++i)
    if (is_lost(i) && !is_reported[i]) all.push_back({.text = text({in.channel(i)}), .subject = in.subject(i)});
  return all;
}

/// Finds unread thermometers and unread analogue channels of the units.
Found check_channel_lost(const CheckInputs& in) {
  const auto is_counted = [&](std::size_t i) { return !in.is_frozen(i); };
  auto lost = find_lost_thermometers(in, InterlockId::channel_lost, is_counted, "");
  for (std::size_t unit = 0; unit < in.sample.units.size(); ++unit) {
    const auto& analogue = in.sample.units[unit].analogue;
    for (std::size_t i = 0; i < analogue.size() && unit < in.limits.units.size(); ++i) {
      if (analogue[i].value) continue;
      const auto channel = analogue_channel(in.limits.units[unit], i);
      lost.push_back({.text = "no reading of " + channel, .subject = channel});
    }
  }
  return lost;
}

Found check_needed_channel_lost(const CheckInputs& in) {
  const auto is_needed = [&](std::size_t i) { return in.is_needed(i) && !in.is_frozen(i); };
  return find_lost_thermometers(in, InterlockId::needed_channel_lost, is_needed, ", which the analysis needs");
}

// ---- the chamber ----------------------------------------------------------------------------------------------------

Found check_chamber_alarm(const CheckInputs& in) {
  if (!in.chamber() || !in.chamber()->must_stop) return {};
  const auto& alarms = in.chamber()->alarms;
  return make_result(fmt::format("chamber alarm: {}", alarms.empty() ? "unnamed" : alarms.front()));
}

Found result_if_active(const CheckInputs& in, ChamberActivity activity, const char* text) {
  return in.chamber() && in.chamber()->activity == activity ? make_result(text) : Found{};
}

Found check_emergency_stop(const CheckInputs& in) {
  return result_if_active(in, ChamberActivity::emergency_stop, "the chamber's emergency stop is pressed");
}
Found check_door(const CheckInputs& in) {
  return result_if_active(in, ChamberActivity::door_open, "the chamber's door is open");
}
Found check_not_following(const CheckInputs& in) {
  return result_if_active(in, ChamberActivity::not_following,
                          "the chamber does not follow its set point: manual mode or open loop");
}
Found check_supply(const CheckInputs& in) {
  return result_if_active(in, ChamberActivity::power_failure, "the chamber has lost its power supply");
}

Found check_not_taken(const CheckInputs& in) {
  if (!in.chamber() || in.facts.led_by_controller || in.facts.refusals < kRefusals) return {};
  return make_result(fmt::format("the chamber refuses set points: {}", in.facts.refusal));
}

/// Formats a set point to 0.01 °C, without trailing zeros. On a ramp it has any number of digits.
std::string format_set_point(Celsius set_point) {
  constexpr double kSteps = 100;
  return fmt::format("{:g} °C", std::round(kSteps * set_point.value) / kSteps);
}

/// Describes how the chamber differs from its commanded state. Returns nothing if it does not differ or may differ.
std::optional<std::string> describe_alteration(const CheckInputs& in) {
  if (!in.chamber() || in.facts.led_by_controller) return std::nullopt;
  const auto& chamber = *in.chamber();
  const auto& sent = in.facts.sent;
  if (chamber.activity == ChamberActivity::off) return "is switched off";
  if (sent && is_program_activity(chamber.activity)) return "runs a program of its own";
  // A unit that cannot show its set point never had one in this run.
  if (sent && std::isnan(chamber.set_point.value) && in.memory.set_point)
    return "has no set point instead of " + format_set_point(*sent);
  if (!sent || !(abs(chamber.set_point - *sent) > in.facts.set_point_tolerance)) return std::nullopt;
  return fmt::format("has the set point {} instead of {}", format_set_point(chamber.set_point),
                     format_set_point(*sent));
}

/// Returns true if the chamber differs because it was restarted: it was silent before, and it did not differ before
/// that silence.
bool was_restarted(const CheckInputs& in) {
  const bool off = in.chamber()->activity == ChamberActivity::off;
  const bool silent_before = !in.memory.chamber_answered || (off && !in.memory.activity_seen);
  return (silent_before && !in.was_found(InterlockId::foreign_set_point)) || in.was_found(InterlockId::restarted) ||
         in.was_found(InterlockId::restarted_off);
}

/// Finds a change made by another program or at the chamber's panel. The cause persists while the chamber is silent,
/// and is not mistaken for a restart afterwards. While this program repeats a refused set point, a different set point
/// is not foreign. A running controller program still is, because it makes a chamber refuse set points.
Found check_foreign_set_point(const CheckInputs& in) {
  if (!in.chamber())
    return in.was_found(InterlockId::foreign_set_point)
               ? make_result(in.memory.most_affected_watch(InterlockId::foreign_set_point).text)
               : Found{};
  const auto what = describe_alteration(in);
  const bool is_our_own =
      (in.facts.sends_again || in.was_found(InterlockId::not_taken)) && !is_program_activity(in.chamber()->activity);
  if (!what || was_restarted(in) || is_our_own) return {};
  return make_result("changed by another program or at its panel: the chamber " + *what);
}

Found find_restart(const CheckInputs& in, bool off) {
  const auto what = describe_alteration(in);
  const bool is_it = what && was_restarted(in) && (in.chamber()->activity == ChamberActivity::off) == off;
  return is_it ? make_result("the chamber was restarted: it " + *what) : Found{};
}
Found check_restarted(const CheckInputs& in) { return find_restart(in, false); }
/// Finds a restart after which the chamber is off. Its reaction is more severe, because someone may have disconnected
/// the chamber to reach inside.
Found check_restarted_off(const CheckInputs& in) { return find_restart(in, true); }

// ---- the power supplies ---------------------------------------------------------------------------------------------

Found list_results(const std::vector<PowerFault>& faults) {
  Found all;
  for (const auto& fault : faults) all.push_back({.text = fault.text, .subject = fault.subject});
  return all;
}
Found check_power_limit(const CheckInputs& in) { return list_results(in.facts.power.outside); }
Found check_power_trip(const CheckInputs& in) { return list_results(in.facts.power.tripped); }
Found check_power_changed(const CheckInputs& in) { return list_results(in.facts.power.changed); }
Found check_power_not_switched(const CheckInputs& in) { return list_results(in.facts.power.not_switched); }

// ---- the program and its record -------------------------------------------------------------------------------------

Found result_if_any(const std::string& text) { return text.empty() ? Found{} : make_result(text); }
Found check_program(const CheckInputs& in) { return result_if_any(in.facts.program); }
/// Finds the instruments that were replaced by another one. Each is a subject.
Found check_another_instrument(const CheckInputs& in) {
  Found all;
  for (const auto& text : in.facts.mismatched_instruments)
    all.push_back({.text = text, .subject = text.substr(0, text.find(':'))});
  return all;
}
/// Finds damaged files. Each is a subject, and its text begins with the file's name.
Found check_record_damaged(const CheckInputs& in) {
  auto found = result_if_any(in.facts.record_damage);
  for (auto& damage : found) damage.subject = damage.text.substr(0, damage.text.find(' '));
  return found;
}
Found check_unguarded(const CheckInputs& in) {
  Found all;
  for (const auto& [subject, text] : in.facts.guard_troubles) all.push_back({.text = text, .subject = subject});
  return all;
}

Found check_deadline(const CheckInputs& in) {
  if (in.sample.progress.phase != Phase::overdue) return {};
  return make_result(fmt::format("segment {} passed its deadline", in.sample.progress.segment + 1));
}

Found check_slept(const CheckInputs& in) {
  if (in.facts.missed <= in.facts.longest_missed) return {};
  return make_result(fmt::format("the program did not run for {}", format_duration(in.facts.missed)));
}

Found check_storage(const CheckInputs& in) {
  const auto& trouble = in.facts.storage_trouble;
  if (in.facts.rows_dropped) return make_result("the record loses rows");
  if (in.facts.backlog <= in.limits.backlog) return {};
  return make_result(fmt::format("the record is {} behind{}{}", format_duration(in.facts.backlog),
                                 trouble.empty() ? "" : ": ", trouble));
}

Found check_wall_clock(const CheckInputs& in) {
  if (!in.memory.utc_minus_run) return {};
  const auto step = in.sample.at.utc - in.sample.at.since_start - *in.memory.utc_minus_run;
  if (std::chrono::abs(step) <= kWallStep) return {};
  return make_result(fmt::format("the time of day was stepped by {:+.3f} s", to_seconds(step)));
}

// ---- unread quantities ----------------------------------------------------------------------------------------------

using Watch = InterlockMemory::Watch;

bool is_chamber_unread(const CheckInputs& in, const Watch&) { return !in.chamber(); }
bool is_dew_point_unread(const CheckInputs& in, const Watch&) {
  return !in.chamber() || !in.chamber()->dew_point || !find_coldest(in.limits, in.sample);
}
bool is_air_rate_unread(const CheckInputs& in, const Watch&) { return !in.memory.air.rate(); }

bool is_comparison_unread(const CheckInputs& in, const Watch&) {
  const auto& compared = in.limits.air_thermometers;
  return !in.chamber() || (!compared.empty() && !median_reading(in.sample, compared));
}

/// Returns the thermometer that showed the cause when it was last found.
std::optional<std::size_t> affected_thermometer(const CheckInputs& in, const Watch& watch) {
  return watch.column && *watch.column < in.sample.thermometers.size() ? watch.column : std::nullopt;
}

bool is_value_unread(const CheckInputs& in, const Watch& watch) {
  const auto column = affected_thermometer(in, watch);
  return column && !known_value(in.sample.thermometers[*column]);
}
bool is_rate_unread(const CheckInputs& in, const Watch& watch) {
  const auto column = affected_thermometer(in, watch);
  return column && !in.memory.thermometers[*column].rate();
}
bool are_others_unread(const CheckInputs& in, const Watch& watch) {
  const auto column = affected_thermometer(in, watch);
  if (!column) return false;
  const auto value = known_value(in.sample.thermometers[*column]);
  return !value || !in.ranks.median_without(value);
}

bool is_power_unread(const CheckInputs& in, const Watch& watch) {
  return std::ranges::count(in.facts.power.unread, watch.subject) > 0;
}

// ---- the table ------------------------------------------------------------------------------------------------------

using L = InterlockLimits;
constexpr Confirmation kSeveralReadings{.samples_limit = &L::confirming_samples};
constexpr Confirmation kSilence{.after_limit = &L::suspend_after, .in_a_row = true};

// clang-format off
constexpr std::array<Interlock, kInterlocks> kTable{{
    {.id = InterlockId::air_limit, .name = "air_limit", .usual = Reaction::abort, .choosable = false,
     .confirmation = kSeveralReadings, .limits = "air_lowest air_highest confirming_samples",
     .check = check_air_limit, .unread = is_chamber_unread},
    {.id = InterlockId::thermometer_limit, .name = "thermometer_limit", .usual = Reaction::abort, .choosable = false,
     .confirmation = kSeveralReadings, .limits = "thermometers_lowest thermometers_highest confirming_samples",
     .check = check_thermometer_limit, .unread = is_value_unread},
    {.id = InterlockId::chamber_alarm, .name = "chamber_alarm", .usual = Reaction::abort, .choosable = false,
     .check = check_chamber_alarm, .unread = is_chamber_unread},
    {.id = InterlockId::emergency_stop, .name = "emergency_stop", .usual = Reaction::abort, .choosable = false,
     .check = check_emergency_stop, .unread = is_chamber_unread},
    {.id = InterlockId::deadline, .name = "deadline", .usual = Reaction::abort, .choosable = false,
     .check = check_deadline},
    {.id = InterlockId::program, .name = "program", .usual = Reaction::abort, .choosable = false,
     .check = check_program},
    {.id = InterlockId::chamber_sensor, .name = "chamber_sensor", .usual = Reaction::abort,
     .confirmation = {.after = seconds(30), .samples = 2}, .limits = "chamber_disagreement air_thermometers",
     .check = check_chamber_sensor, .unread = is_comparison_unread},
    {.id = InterlockId::chamber_silent, .name = "chamber_silent", .usual = Reaction::suspend,
     .confirmation = kSilence, .lost_after = &L::chamber_lost, .limits = "suspend_after chamber_lost",
     .check = check_chamber_silent},
    {.id = InterlockId::thermometers_lost, .name = "thermometers_lost", .usual = Reaction::suspend,
     .confirmation = kSilence, .lost_after = &L::thermometers_lost,
     .limits = "thermometers_needed suspend_after thermometers_lost", .check = check_thermometers_lost},
    {.id = InterlockId::needed_channel_lost, .name = "needed_channel_lost", .usual = Reaction::suspend,
     .confirmation = kSilence, .limits = "suspend_after", .check = check_needed_channel_lost},
    {.id = InterlockId::gyro_silent, .name = "gyro_silent", .usual = Reaction::suspend,
     .confirmation = kSilence, .lost_after = &L::gyro_lost, .limits = "suspend_after gyro_lost",
     .check = check_gyro_silent},
    {.id = InterlockId::unit_silent, .name = "unit_silent", .usual = Reaction::warn,
     .confirmation = kSilence, .limits = "suspend_after", .check = check_unit_silent},
    {.id = InterlockId::door, .name = "door", .usual = Reaction::suspend, .check = check_door,
     .unread = is_chamber_unread},
    {.id = InterlockId::supply, .name = "supply", .usual = Reaction::suspend, .check = check_supply,
     .unread = is_chamber_unread},
    {.id = InterlockId::air_rate, .name = "air_rate", .usual = Reaction::suspend,
     .confirmation = {.after = seconds(5), .samples = 5}, .limits = "air_fastest",
     .check = check_air_rate, .unread = is_air_rate_unread},
    {.id = InterlockId::thermometer_rate, .name = "thermometer_rate", .usual = Reaction::suspend,
     .confirmation = {.after = seconds(5), .samples = 5}, .limits = "thermometers_fastest",
     .check = check_thermometer_rate, .unread = is_rate_unread},
    {.id = InterlockId::following, .name = "following", .usual = Reaction::suspend,
     .confirmation = {.after_limit = &L::follow_time, .samples = 2}, .limits = "chamber_lag follow_band follow_time",
     .check = check_following, .unread = is_chamber_unread},
    {.id = InterlockId::frozen, .name = "frozen", .usual = Reaction::suspend, .limits = "frozen_after",
     .check = find_frozen_instruments},
    {.id = InterlockId::gyro_dead, .name = "gyro_dead", .usual = Reaction::suspend,
     .limits = "gyro_dead_after gyro_band", .check = find_dead_axes},
    {.id = InterlockId::no_thermal_response, .name = "no_thermal_response", .usual = Reaction::hold,
     .confirmation = {.after_limit = &L::response_time, .samples = 2}, .limits = "response_step response_time",
     .check = find_missing_response},
    {.id = InterlockId::power_limit, .name = "power_limit", .usual = Reaction::hold,
     .confirmation = kSeveralReadings, .limits = "confirming_samples", .check = check_power_limit,
     .unread = is_power_unread},
    {.id = InterlockId::power_trip, .name = "power_trip", .usual = Reaction::hold, .check = check_power_trip,
     .unread = is_power_unread},
    {.id = InterlockId::power_changed, .name = "power_changed", .usual = Reaction::hold,
     .confirmation = kSeveralReadings, .limits = "confirming_samples", .check = check_power_changed,
     .unread = is_power_unread},
    {.id = InterlockId::power_not_switched, .name = "power_not_switched", .usual = Reaction::suspend,
     .confirmation = kSilence, .limits = "suspend_after", .check = check_power_not_switched},
    {.id = InterlockId::another_instrument, .name = "another_instrument", .usual = Reaction::hold,
     .check = check_another_instrument},
    {.id = InterlockId::foreign_set_point, .name = "foreign_set_point", .usual = Reaction::suspend,
     .confirmation = kSeveralReadings, .limits = "confirming_samples", .check = check_foreign_set_point},
    {.id = InterlockId::not_following, .name = "not_following", .usual = Reaction::suspend,
     .confirmation = kSeveralReadings, .limits = "confirming_samples", .check = check_not_following,
     .unread = is_chamber_unread},
    {.id = InterlockId::restarted, .name = "restarted", .usual = Reaction::suspend,
     .check = check_restarted, .unread = is_chamber_unread},
    {.id = InterlockId::restarted_off, .name = "restarted_off", .usual = Reaction::hold,
     .check = check_restarted_off, .unread = is_chamber_unread},
    {.id = InterlockId::not_taken, .name = "not_taken", .usual = Reaction::suspend,
     .check = check_not_taken, .unread = is_chamber_unread},
    {.id = InterlockId::slept, .name = "slept", .usual = Reaction::hold, .check = check_slept},
    {.id = InterlockId::storage, .name = "storage", .usual = Reaction::warn, .limits = "backlog",
     .check = check_storage},
    {.id = InterlockId::record_damaged, .name = "record_damaged", .usual = Reaction::warn, .is_never_over = true,
     .check = check_record_damaged},
    {.id = InterlockId::unguarded, .name = "unguarded", .usual = Reaction::warn, .check = check_unguarded},
    {.id = InterlockId::channel_lost, .name = "channel_lost", .usual = Reaction::warn, .check = check_channel_lost},
    {.id = InterlockId::disagreement, .name = "disagreement", .usual = Reaction::warn,
     .confirmation = {.after = seconds(60), .samples = 60}, .limits = "disagreement",
     .check = check_disagreement, .unread = are_others_unread},
    {.id = InterlockId::stuck, .name = "stuck", .usual = Reaction::warn, .check = check_stuck,
     .unread = are_others_unread},
    {.id = InterlockId::drifting, .name = "drifting", .usual = Reaction::warn,
     .confirmation = {.after = seconds(30), .samples = 30}, .limits = "drift", .check = find_drifting_thermometers,
     .unread = is_value_unread},
    {.id = InterlockId::condensation, .name = "condensation", .usual = Reaction::warn,
     .confirmation = {.after = seconds(30), .samples = 2}, .limits = "condensation_margin",
     .check = find_condensation, .unread = is_dew_point_unread},
    {.id = InterlockId::cold_at_door, .name = "cold_at_door", .usual = Reaction::warn,
     .check = find_cold_unit_at_door},
    {.id = InterlockId::wall_clock, .name = "wall_clock", .usual = Reaction::warn, .check = check_wall_clock},
}};
// clang-format on

constexpr bool is_table_in_order() {
  for (std::size_t i = 0; i < kInterlocks; ++i)
    if (static_cast<std::size_t>(kTable[i].id) != i) return false;
  return true;
}
static_assert(is_table_in_order(), "each interlock has its row, in the order of their names");

// ---- judging --------------------------------------------------------------------------------------------------------

/// Returns the reaction of an interlock that acts.
Reaction effective_reaction(const InterlockLimits& limits, const Interlock& row, const CheckResult& found,
                            Duration lasted) {
  const bool lost = row.lost_after != nullptr && lasted >= limits.*row.lost_after;
  return found.grave || lost ? Reaction::abort
                             : std::min(found.at_most, limits.policy[static_cast<std::size_t>(row.id)]);
}

/// Adds a sample in which the quantity was read. Returns true if the interlock acts: its cause was present in `samples`
/// of the last 2 × `samples` samples and for `after` within the last 2 × `after`, or, with `in_a_row`, for `after`
/// without a break. `replaced` replaces `after`.
bool is_confirmed(const InterlockLimits& limits, const Confirmation& needs, bool found, Duration elapsed,
                  InterlockMemory::Watch& watch, std::optional<Duration> replaced = {}) {
  const auto after = replaced.value_or(needs.after_limit != nullptr ? limits.*needs.after_limit : needs.after);
  const auto samples = needs.samples_limit != nullptr ? limits.*needs.samples_limit : needs.samples;
  watch.recent.add(found, elapsed, 2 * samples, after * 2);
  if (needs.in_a_row) return found && watch.lasted >= after;
  return found && watch.recent.time() >= after && watch.recent.samples() >= samples;
}

/// Clears the alarm when its cause has been absent or unread for long enough.
void clear_if_due(const InterlockLimits& limits, InterlockId id, Duration elapsed, InterlockMemory::Watch& watch,
                  std::vector<InterlockAlarm>& cleared) {
  watch.gone += elapsed;
  if (!watch.raised || watch.gone < limits.clear_after) return;
  watch.raised = false;
  watch.reported = {};
  watch.recent.forget();
  cleared.push_back({id, Reaction::go_on, watch.text, watch.subject});
}

void raise_demand(const InterlockMemory::Watch& watch, InterlockDemand& most) {
  if (watch.reaction > most.reaction) most = {watch.reaction, watch.text};
}

/// Keeps the state of a cause while its quantity is unread, because a lost reading does not prove that the cause has
/// ended. After suspend_after without a reading, the cause is treated as absent.
void keep_unread_cause(const InterlockLimits& limits, InterlockId id, Duration elapsed, Watch& watch,
                       InterlockResult& judged) {
  watch.unseen += elapsed;
  if (watch.unseen <= limits.suspend_after) return raise_demand(watch, judged.demand);
  watch.reaction = {};
  clear_if_due(limits, id, elapsed, watch, judged.cleared);
}

/// Returns the time to add to a cause's duration. Includes the time without ticks only if the cause was present before
/// it and the machine did not sleep; a sleep has its own interlock.
Duration covered_time(const InterlockMemory::Watch& watch, Duration elapsed, const InterlockInputs& inputs) {
  const bool counts = watch.samples > 0 && inputs.missed <= inputs.longest_missed;
  return counts ? elapsed : elapsed - inputs.missed;
}

/// Advances the watch of one subject by a second. `found` is null if its cause was not found.
void step(const InterlockLimits& limits, const Interlock& row, const CheckResult* found, bool unread, Duration elapsed,
          const InterlockInputs& inputs, Watch& watch, InterlockResult& judged) {
  if (!found && unread && watch.samples > 0) return keep_unread_cause(limits, row.id, elapsed, watch, judged);
  const auto unseen = std::exchange(watch.unseen, Duration{});
  watch.reaction = row.is_never_over ? std::min(watch.reaction, Reaction::warn) : Reaction::go_on;
  if (!found && row.is_never_over) return raise_demand(watch, judged.demand);
  if (!found) {
    watch.lasted = {};
    watch.samples = 0;
    if (!unread) (void)is_confirmed(limits, row.confirmation, false, elapsed, watch);
    return clear_if_due(limits, row.id, elapsed, watch, judged.cleared);
  }
  watch.gone = {};
  const auto covered = covered_time(watch, elapsed, inputs) + (unseen <= limits.suspend_after ? unseen : Duration{});
  watch.lasted += covered;
  ++watch.samples;
  watch.column = found->column;
  const bool is_news = !watch.raised || watch.text != found->text;
  watch.text = found->text;
  if (!is_confirmed(limits, row.confirmation, true, covered, watch, found->after)) return;
  watch.reaction = effective_reaction(limits, row, *found, watch.lasted);
  if (row.is_never_over && !is_news) watch.reaction = std::min(watch.reaction, Reaction::warn);
  if (row.lost_after != nullptr) watch.text += " for " + format_duration(watch.lasted);
  watch.text += found->detail;
  if (!std::exchange(watch.raised, true) || watch.reaction > watch.reported) {
    watch.reported = watch.reaction;
    judged.raised.push_back({row.id, watch.reaction, watch.text, watch.subject});
  }
  raise_demand(watch, judged.demand);
}

/// The results of one interlock's check. `unread` has one flag per watched subject: true if the quantity that shows its
/// cause was not read.
struct Verdict {
  Found found;
  std::vector<bool> unread;
};

/// Advances every subject of an interlock that has, or had, a cause.
void step(const InterlockLimits& limits, const Interlock& row, const Verdict& verdict, Duration elapsed,
          const InterlockInputs& inputs, InterlockResult& judged) {
  auto& watches = judged.memory.watches[static_cast<std::size_t>(row.id)];
  for (const auto& one : verdict.found)
    if (std::ranges::find(watches, one.subject, &Watch::subject) == watches.end())
      watches.push_back({.subject = one.subject});
  for (std::size_t i = 0; i < watches.size(); ++i) {
    const auto one = std::ranges::find(verdict.found, watches[i].subject, &CheckResult::subject);
    const auto* found = one != verdict.found.end() ? &*one : nullptr;
    step(limits, row, found, i < verdict.unread.size() && verdict.unread[i], elapsed, inputs, watches[i], judged);
  }
  std::erase_if(watches,
                [](const Watch& watch) { return !watch.raised && watch.samples == 0 && watch.recent.samples() == 0; });
}

}  // namespace

const Interlock& interlock(InterlockId id) { return kTable[static_cast<std::size_t>(id)]; }

Policy default_policy() {
  Policy policy{};
  for (std::size_t i = 0; i < kInterlocks; ++i) policy[i] = kTable[i].usual;
  return policy;
}

const char* name(Reaction reaction) {
  switch (reaction) {
    case Reaction::go_on: return "go_on";
    case Reaction::warn: return "warn";
    case Reaction::suspend: return "suspend";
    case Reaction::hold: return "hold";
    case Reaction::abort: return "abort";
  }
  return "";
}

InterlockResult judge(const InterlockLimits& limits, InterlockMemory memory, const Sample& sample, Duration elapsed,
                      const InterlockInputs& inputs) {
  remember(limits, sample,
           {.elapsed = elapsed - inputs.missed,
            .missed = inputs.missed,
            .gyro_is_off = inputs.gyro_is_off,
            .units_are_moved = inputs.units_are_moved,
            .is_turned = inputs.is_turned},
           memory.liveness);
  Sample alive = sample;
  mask_dead_readings(limits, memory.liveness, alive);
  const auto explained = memory.explained;
  remember(limits, alive, elapsed, inputs.missed > Duration{}, memory);
  std::array<Verdict, kInterlocks> verdicts;
  const CheckInputs second{limits, memory, alive, inputs, Ranks(alive)};
  if (const auto& chamber = alive.chamber.value)
    note_alteration(describe_alteration(second).has_value(), explained, *chamber, memory);
  for (std::size_t i = 0; i < kInterlocks; ++i) {
    verdicts[i].found = kTable[i].check(second);
    for (const auto& watch : memory.watches[i])
      verdicts[i].unread.push_back(kTable[i].unread != nullptr && kTable[i].unread(second, watch));
  }
  memory.utc_minus_run = sample.at.utc - sample.at.since_start;
  const auto& chamber = sample.chamber.value;
  memory.chamber_answered = chamber.has_value();
  memory.activity_seen = chamber && (memory.activity_seen || chamber->activity != ChamberActivity::unknown);
  InterlockResult judged{.demand = {}, .memory = std::move(memory), .raised = {}, .cleared = {}};
  for (std::size_t i = 0; i < kInterlocks; ++i) step(limits, kTable[i], verdicts[i], elapsed, inputs, judged);
  return judged;
}

InterlockDemand demand_without(const InterlockMemory& memory, const std::vector<InterlockId>& some) {
  InterlockDemand most;
  for (std::size_t i = 0; i < kInterlocks; ++i)
    for (const auto& watch : memory.watches[i])
      if (std::ranges::count(some, static_cast<InterlockId>(i)) == 0) raise_demand(watch, most);
  return most;
}

std::vector<InterlockId> causes_ended_by_resume(const InterlockMemory& memory) {
  std::vector<InterlockId> some;
  for (const auto id : {InterlockId::foreign_set_point, InterlockId::not_following})
    if (memory.is_active(id)) some.push_back(id);
  for (const auto id : {InterlockId::restarted, InterlockId::restarted_off})
    if (memory.is_active(id) && memory.most_affected_watch(id).reaction == Reaction::hold) some.push_back(id);
  for (const auto id : {InterlockId::power_trip, InterlockId::power_changed})
    if (memory.is_active(id)) some.push_back(id);
  return some;
}

bool is_about_power(InterlockId id) { return id >= InterlockId::power_limit && id <= InterlockId::power_not_switched; }

std::vector<std::string> active_faults(const InterlockMemory& memory) {
  std::vector<std::string> lines;
  for (const auto& watches : memory.watches)
    for (const auto& watch : watches)
      if (watch.raised) lines.push_back(watch.text);
  return lines;
}

}  // namespace gyrotherm::interlocks
