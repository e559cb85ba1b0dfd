// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "acquisition/record/run_info.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/release/program_register.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/readiness.hpp"
#include "core/clock.hpp"
#include "core/count_text.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/line_address.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/prove/make_safe_proof.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/run/chamber_ownership.hpp"
#include "sequencer/run/set_point_path.hpp"
#include "sequencer/watchdog/guard_post.hpp"

namespace gyrotherm::app {
namespace {

struct CheckArguments {
  std::string profile;
  std::string rig;
  bool connect = false;
  std::uint64_t seed = 0;
};

std::string thermal_model(const rig::RigFile& rig) {
  const auto& model = rig.gyro_model;
  return model.name.empty() ? "" : fmt::format(", thermal model \"{}\", film \"{}\"", model.name, model.film);
}

/// Describes the chamber's own limiter, which is the safety function. Warns if the file of a real rig does not describe
/// it.
std::string limiter_line(const rig::RigFile& rig) {
  if (rig.limiter) {
    const auto first = rig::describe_limiter_that_trips_first(rig);
    return fmt::format("    its limiter trips: {}; verify these settings on the chamber\n{}", describe(*rig.limiter),
                       first.empty() ? "" : fmt::format("    WARNING: {}\n", first));
  }
  if (rig.simulated) return {};
  return "    WARNING: the rig file does not contain the settings of the chamber's own limiter ([chamber.limiter]); "
         "the limiter is the safety function, this program is not\n";
}

/// Returns what the program cannot see because the map of a real chamber has no states; empty if it has.
std::string unseen_states(const rig::RigFile& rig) {
  if (rig.simulated || !rig.chamber_map.states.empty()) return {};
  return fmt::format(
      "the map of the {} has no [[state]]: the program cannot see that the chamber is off or in manual mode, and a run "
      "continues until an interlock of the air or of a thermometer trips",
      rig.chamber_map.name);
}

std::string state_line(const rig::RigFile& rig) {
  const auto unseen = unseen_states(rig);
  return unseen.empty() ? "" : fmt::format("    WARNING: {}\n", unseen);
}

std::string chamber_line(const rig::RigFile& rig) {
  const auto& limits = rig.chamber_limits;
  return fmt::format(
      "  chamber {}, {:g} … {:g} °C, heats at up to {:g}, cools at up to {:g} °C/min, safe at {:g} °C\n    {}\n{}",
      rig.chamber_map.name, limits.lowest.value, limits.highest.value, limits.fastest_heating.value,
      limits.fastest_cooling.value, rig.safe_set_point.value, describe_confidence(rig.chamber_map),
      state_line(rig) + limiter_line(rig));
}

std::string thermometer_lines(const rig::RigFile& rig) {
  const auto channels = list_channels(rig);
  auto lines = fmt::format("  {} thermometers\n", channels.size());
  for (const auto& channel : channels)
    if (const auto words = describe_calibration(channel); words != "none")
      lines += fmt::format("    {}: {}\n", channel.name, words);
  for (const auto& channel : channels)
    if (channel.certificate_file)
      lines += fmt::format("    {}: {}\n", channel.name, describe_certificate_file(*channel.certificate_file));
  for (const auto& settings : rig.thermometers)
    if (!settings.command.words.empty())
      lines +=
          fmt::format("    {}: read by the program {}\n", fmt::join(settings.channels, " "), text(settings.command));
  for (const auto& settings : rig.thermometers)
    if (settings.description)
      lines += fmt::format("    {}: {} at {}, {}\n", fmt::join(settings.channels, " "), settings.description->unit.name,
                           settings.line, describe_confidence(*settings.description));
  for (const auto& line : list_overdue(rig)) lines += fmt::format("    WARNING: {}\n", line);
  return lines;
}

/// Describes the gyro of a rig with one axis.
std::string gyro_line(const rig::RigFile& rig) {
  const auto& stream = rig.gyro_lines.front().stream;
  const auto& gyro = *rig.gyro_lines.front().frame.gyro();
  const auto counts =
      is_counted(gyro)
          ? fmt::format("{:g} arcsec per {}", rig.units.front().info.axes.front().scale, stream ? "count" : "pulse")
          : fmt::format("sends {} {}", gyro.role == drivers::FieldRole::rate ? "rates in" : "angles in", gyro.unit);
  if (!stream) return fmt::format("  gyro {}{}\n", counts, thermal_model(rig));
  return fmt::format("  gyro {} ({}), {}{}\n    description: {}, from {}\n", stream->name, stream->vendor, counts,
                     thermal_model(rig), stream->confidence, stream->source);
}

/// Returns a table row for one axis of a unit.
std::string axis_row(const rig::UnitSettings& unit, std::size_t index, const rig::GyroLine& line) {
  const auto& info = unit.info;
  const auto& axis = info.axes[index];
  const auto earth = axis.earth_rate ? fmt::format("{:.4f}", axis.earth_rate->value) : "unknown";
  return fmt::format("    {:<10} {:<14} {:<16} {:<22} {:>11} {:>12.6g}  {}\n", axis_label(info, index),
                     index == 0 ? info.serial_number : "", index == 0 ? line.frame.name : "",
                     index == 0 ? line.line : "", earth, axis.scale,
                     index == 0 ? fmt::format("{}", fmt::join(info.gradients, " ")) : "");
}

/// Returns the units under test as a table with a row per axis.
std::string lot_lines(const rig::RigFile& rig) {
  auto lines = fmt::format("  {} units under test{}\n    {:<10} {:<14} {:<16} {:<22} {:>11} {:>12}  {}\n",
                           rig.units.size(), thermal_model(rig), "axis", "serial number", "frames", "line", "earth °/h",
                           "arcsec/count", "thermometers");
  for (std::size_t unit = 0; unit < rig.units.size(); ++unit) {
    const auto& info = rig.units[unit].info;
    for (std::size_t i = 0; i < info.axes.size(); ++i) lines += axis_row(rig.units[unit], i, find_gyro_line(rig, unit));
    std::vector<std::string> values;
    for (const auto& value : info.values) values.push_back(fmt::format("{} [{}]", value.name, value.unit));
    if (!values.empty()) lines += fmt::format("      housekeeping: {}\n", fmt::join(values, ", "));
  }
  return lines;
}

std::string analogue_lines(const rig::RigFile& rig) {
  std::string lines;
  for (std::size_t i = 0; i < rig.analogue_inputs.size(); ++i) {
    const auto& [line, map, channels] = rig.analogue_inputs[i];
    lines += fmt::format("  {} {} at {}\n    {}\n", rig::analogue_title(i), map.registers.name, line,
                         describe_confidence(map));
    for (const auto& channel : channels)
      lines += fmt::format("    input {}: {}.{}\n", channel.input + 1, rig.units[channel.unit].info.name, channel.name);
  }
  return lines;
}

std::string supply_lines(const rig::RigFile& rig) {
  std::string lines;
  for (std::size_t i = 0; i < rig.supplies.size(); ++i)
    lines += fmt::format("  {}: {}\n    {}\n", rig::supply_title(i), describe(rig.supplies[i], rig.units),
                         describe_confidence(rig.supplies[i].description));
  const auto unfed = list_unfed_units(rig.supplies, rig.units);
  if (!unfed.empty())
    lines += fmt::format("    an operator switches the units without a supply: {}\n", fmt::join(unfed, ", "));
  return lines;
}

/// Returns a sentence for each serial line whose device name may change.
std::vector<std::string> unstable_names(const rig::RigFile& rig) {
  std::vector<std::string> sentences;
  for (const auto& connected : instrument_lines(rig))
    if (const auto why = unstable_name(connected.line); !why.empty())
      sentences.push_back(fmt::format("{}: {}", connected.title, why));
  return sentences;
}

/// Returns a sentence for each network address of two instruments that cannot share a connection: gyros, which send by
/// themselves, and thermometers of a built-in driver without an address.
std::vector<std::string> list_shared_connections(const rig::RigFile& rig) {
  std::vector<std::string> lines, sentences;
  if (rig.simulated) return sentences;
  for (const auto& gyro : rig.gyro_lines) lines.push_back(gyro.line);
  for (const auto& settings : rig.thermometers)
    if (settings.kind != drivers::ThermometerKind::dcon && settings.kind != drivers::ThermometerKind::text)
      lines.push_back(settings.line);
  std::map<std::string, int> users;
  for (const auto& line : lines)
    if (const auto parsed = drivers::parse_line(line); parsed && std::holds_alternative<drivers::TcpLine>(*parsed))
      ++users[line];
  for (const auto& [line, count] : users)
    if (count > 1)
      sentences.push_back(
          fmt::format("{} is the line of {} gyros or thermometers; each needs a connection of its own", line, count));
  return sentences;
}

std::string shared_connection_lines(const rig::RigFile& rig) {
  std::string lines;
  for (const auto& sentence : list_shared_connections(rig)) lines += fmt::format("  WARNING: {}\n", sentence);
  return lines;
}

std::string unstable_lines(const rig::RigFile& rig) {
  std::string lines;
  for (const auto& sentence : unstable_names(rig)) lines += fmt::format("  WARNING: {}\n", sentence);
  return lines;
}

/// Describes how many set points a run sends. Warns if the controller stores each of them in memory with limited
/// writes.
std::string set_point_lines(std::int64_t count, const rig::RigFile* rig) {
  auto lines = fmt::format("\n  a run sends {}\n", format_count(count, "set point"));
  const auto endures = rig ? rig->chamber_map.limits.nonvolatile : 0;
  if (endures == 0) return lines;
  return lines + fmt::format(
                     "  WARNING: the controller stores each of them in memory that is rated for {} writes: {:.3g} % of "
                     "its life. Prevent storing (a register written in `start`), set `every` in the [limits] of its "
                     "map{}\n",
                     endures, 100.0 * static_cast<double>(count) / static_cast<double>(endures),
                     rig->chamber_map.memory ? ", or let it carry out the profile (run --upload)" : "");
}

bool is_one_axis(const rig::RigFile& rig) { return rig.units.size() == 1 && rig.units.front().info.axes.size() == 1; }

std::string bias_zero_line(const rig::RigFile& rig) {
  const auto zero = check_bias_zero(rig);
  return zero.state == FindingState::ok ? "" : fmt::format("    WARNING: {}; {}\n", zero.found, zero.fix);
}

/// Returns a sentence if the safe set point leaves a unit colder than the dew point of the room.
std::string cold_safe_state(const rig::RigFile& rig) {
  const auto& room = rig.limits.room;
  if (!room || rig.safe_set_point >= room->warm_from()) return "";
  return fmt::format(
      "the safe state of {:g} °C is colder than the {:.1f} °C at which the door may be opened: warm the unit first",
      rig.safe_set_point.value, room->warm_from().value);
}

std::string room_lines(const rig::RigFile& rig) {
  const auto& room = rig.limits.room;
  std::string lines;
  if (records_humidity(rig)) lines += "  humidity and dew point of the chamber are recorded\n";
  if (records_dew_point(rig) && !records_humidity(rig)) lines += "  the dew point of the chamber is recorded\n";
  if (!room) return lines;
  lines += fmt::format("  room: dew point {:.1f} °C; the door may be opened when the unit is at {:.1f} °C or more\n",
                       room->dew_point.value, room->warm_from().value);
  const auto cold = cold_safe_state(rig);
  return cold.empty() ? lines : lines + fmt::format("    WARNING: {}\n", cold);
}

/// Describes the proof tests: what is due, and the second way to switch the chamber off.
std::string proof_lines(const rig::RigFile& rig) {
  std::string lines;
  if (rig.safe_also) lines += fmt::format("    if it cannot be made safe: {}\n", describe(*rig.safe_also));
  for (const auto& line : list_due_proofs(rig)) lines += fmt::format("    WARNING: {}\n", line);
  return lines;
}

/// Returns the position of the relay as a warning; empty if it is closed.
std::string relay_line(const rig::RigFile& rig) {
  const auto why = rig.simulated ? "" : prove::relay_refusal_reason(rig, rig.file);
  return why.empty() ? "" : fmt::format("  WARNING: {}\n", why);
}

std::string rig_lines(const rig::RigFile& rig) {
  return fmt::format("{}: {}{}\n", rig.file, rig.simulated ? "SIMULATED, " : "", rig.title) + chamber_line(rig) +
         proof_lines(rig) + thermometer_lines(rig) + (is_one_axis(rig) ? gyro_line(rig) : lot_lines(rig)) +
         bias_zero_line(rig) + analogue_lines(rig) + supply_lines(rig) + room_lines(rig) + unstable_lines(rig) +
         shared_connection_lines(rig);
}

Json calibrations_json(const rig::RigFile& rig) {
  auto json = Json::object();
  for (const auto& channel : list_channels(rig)) json[channel.name] = describe_calibration(channel);
  return json;
}

/// Returns the certificate files by the channels that they calibrate.
Json certificates_json(const rig::RigFile& rig) {
  auto json = Json::object();
  for (const auto& channel : list_channels(rig)) {
    if (!channel.certificate_file) continue;
    const auto& file = *channel.certificate_file;
    const auto& known = channel.uncertainty;
    json[channel.name] = {{"number", channel.certificate},
                          {"file", file.name},
                          {"sha256", file.sha256},
                          {"issuer", file.issuer},
                          {"signer", file.signer},
                          {"offset_k", channel.offset.value},
                          {"standard_uncertainty_k", known.calibration ? Json(known.calibration->value) : Json()},
                          {"expanded_k", file.expanded.value},
                          {"coverage_factor", file.coverage_factor},
                          {"lowest_c", file.lowest.value},
                          {"highest_c", file.highest.value},
                          {"calibrated", known.calibrated ? record::format_day(*known.calibrated) : ""},
                          {"due", channel.due ? record::format_day(*channel.due) : ""}};
  }
  return json;
}

Json units_json(const rig::RigFile& rig) {
  auto units = Json::array();
  for (std::size_t unit = 0; unit < rig.units.size(); ++unit) {
    const auto& info = rig.units[unit].info;
    auto axes = Json::array(), values = Json::array();
    for (const auto& axis : info.axes)
      axes.push_back({{"name", axis.name},
                      {"scale", axis.scale},
                      {"earth_rate_deg_per_h", axis.earth_rate ? Json(axis.earth_rate->value) : Json()}});
    for (const auto& value : info.values) values.push_back({{"name", value.name}, {"unit", value.unit}});
    units.push_back({{"name", info.name},
                     {"serial_number", info.serial_number},
                     {"model", info.model},
                     {"line", find_gyro_line(rig, unit).line},
                     {"axes", axes},
                     {"values", values},
                     {"thermometers", info.gradients}});
  }
  return units;
}

Json rig_json(const rig::RigFile& rig) {
  const auto& limits = rig.chamber_limits;
  const auto& stream = rig.gyro_lines.front().stream;
  return {{"file", rig.file},
          {"simulated", rig.simulated},
          {"chamber", rig.chamber_map.name},
          {"chamber_confidence", describe_confidence(rig.chamber_map)},
          {"lowest_c", limits.lowest.value},
          {"highest_c", limits.highest.value},
          {"fastest_heating_c_per_min", limits.fastest_heating.value},
          {"fastest_cooling_c_per_min", limits.fastest_cooling.value},
          {"safe_set_point_c", rig.safe_set_point.value},
          {"limiter", rig.limiter ? describe(*rig.limiter) : ""},
          {"unseen_states", unseen_states(rig)},
          {"relay", rig.safe_also ? describe(*rig.safe_also) : ""},
          {"proof_tests", list_due_proofs(rig)},
          {"humidity", records_humidity(rig)},
          {"dew_point", records_dew_point(rig)},
          {"door_from_c", rig.limits.room ? Json(rig.limits.room->warm_from().value) : Json()},
          {"cold_safe_state", cold_safe_state(rig)},
          {"thermometers", list_channels(rig).size()},
          {"calibrations", calibrations_json(rig)},
          {"certificates", certificates_json(rig)},
          {"overdue", list_overdue(rig)},
          {"unstable_names", unstable_names(rig)},
          {"shared_connections", list_shared_connections(rig)},
          {"bias_zero_known", check_bias_zero(rig).state == FindingState::ok},
          {"arcsec_per_pulse", rig.units.front().info.axes.front().scale},
          {"gyro_stream", stream ? stream->name : ""},
          {"gyro_stream_confidence", stream ? stream->confidence : ""},
          {"units", units_json(rig)},
          {"gyro_model", rig.gyro_model.name},
          {"gyro_film", rig.gyro_model.film}};
}

/// Returns a sentence for each limit that ends a run and that a set point of the profile reaches: a reading slightly
/// beyond the set point is enough.
std::vector<std::string> list_reached_limits(const profile::Profile& profile, const rig::RigFile& rig) {
  std::optional<Celsius> lowest, highest;
  each_released(profile, [&](const profile::Segment& segment, Celsius) {
    lowest = std::min(lowest.value_or(segment.target), segment.target);
    highest = std::max(highest.value_or(segment.target), segment.target);
  });
  std::vector<std::string> sentences;
  const auto compare = [&](const std::string& which, Celsius low, Celsius high) {
    const auto add = [&](Celsius set_point, Celsius limit, const char* side) {
      sentences.push_back(fmt::format("the set point of {:g} °C reaches a limit of {}: a run ends {} {:g} °C",
                                      set_point.value, which, side, limit.value));
    };
    if (lowest && *lowest <= low) add(*lowest, low, "below");
    if (highest && *highest >= high) add(*highest, high, "above");
  };
  const auto& limits = rig.limits;
  compare("the air", limits.air_lowest, limits.air_highest);
  if (limits.thermometers.empty()) compare("the thermometers", limits.thermometers_lowest, limits.thermometers_highest);
  for (std::size_t i = 0; i < limits.thermometers.size(); ++i)
    compare("thermometer " + limits.channels[i], limits.thermometers[i].lowest, limits.thermometers[i].highest);
  return sentences;
}

/// Returns the goal and the blocks of a run that ends by itself, with their times at the end of the opening; null for
/// another run.
Json until_json(const profile::Profile& profile) {
  if (!profile.until) return nullptr;
  const auto from = profile.segments.back().target;
  const auto seconds = [&](const profile::ReleasedBlock& block) {
    const auto* expanded = find_expansion(block, from);
    return expanded ? total_time(expanded->segments) / std::chrono::seconds(1) : 0;
  };
  auto blocks = Json::array();
  for (const auto& block : profile.until->blocks) blocks.push_back({{"name", block.name}, {"seconds", seconds(block)}});
  return {{"u_deg_per_h", profile.until->u_deg_per_h},
          {"mission", profile.until->mission},
          {"longest_s", profile.until->longest / std::chrono::seconds(1)},
          {"blocks", blocks},
          {"closing_seconds", seconds(profile.until->closing)}};
}

Json timeline_json(const profile::Profile& profile, const profile::Timeline& timeline) {
  const auto total = [](const profile::CycleTotal& cycle) {
    return Json{{"name", cycle.name},
                {"seconds", (cycle.ramps + cycle.holds) / std::chrono::seconds(1)},
                {"clusters", cycle.clusters}};
  };
  Json json{{"name", profile.name}, {"segments", profile.segments.size()}, {"all", total(timeline.all)}};
  json["cycles"] = Json::array();
  for (const auto& cycle : timeline.cycles) json["cycles"].push_back(total(cycle));
  json["until"] = until_json(profile);
  return json;
}

/// Identities that the instruments reported, and the first fault.
struct Answers {
  std::vector<std::string> all;
  std::optional<Fault> fault;
};

Result<std::unique_ptr<rig::Rig>> assemble(const rig::RigFile& file, std::uint64_t seed) {
  return rig::Rig::assemble(file, {.seed = {.gyro = seed, .run = 0}, .elapsed = {}, .replay = {}});
}

/// Queries the identity of each instrument, reads it once, and reads the chamber's set point limits.
Result<Answers> query_instruments(const rig::RigFile& file, std::uint64_t seed, drivers::SetPointRange& limits) {
  auto rig = assemble(file, seed);
  if (!rig) return failure(rig.error());
  Answers answers;
  for (const auto& answer : (*rig)->query_instruments()) {
    answers.all.push_back(answer ? *answer : "FAULT " + text(answer.error()));
    if (!answer && !answers.fault) answers.fault = answer.error();
  }
  if (answers.fault) return answers;
  const auto found = (*rig)->controller_limits();
  if (!found) return failure(found.error());
  limits = *found;
  return answers;
}

/// The findings as text and as data.
struct Findings {
  std::string words;
  Json json;
  drivers::SetPointRange controller;  ///< set only after a query
  std::optional<Fault> fault{};
};

/// Adds the guards of dead runs that make the chamber of a real rig safe, or wait for it.
void list_waiting_guards(const rig::RigFile& rig, Findings& found) {
  found.json["waiting_guards"] = Json::array();
  if (rig.simulated) return;
  for (const auto& guard : watchdog::find_waiting_guards(run::chamber_lock_name(rig))) {
    found.words += fmt::format(
        "  warning: {}, makes this chamber safe or waits for it; it ends once a run drives the chamber\n", guard.words);
    found.json["waiting_guards"].push_back({{"pid", guard.pid}, {"record", guard.record}});
  }
}

/// Checks the rig and, with --connect, its instruments.
Result<rig::RigFile> check_rig(const CheckArguments& options, Findings& found) {
  auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  if (!rig->simulated && options.seed != 0) return failure(FaultKind::usage, "--seed", "only valid on a virtual rig");
  if (rig->simulated && !options.connect)
    if (const auto assembled = assemble(*rig, options.seed); !assembled) return failure(assembled.error());
  found.words += rig_lines(*rig);
  found.json["rig"] = rig_json(*rig);
  if (!options.connect) return rig;
  if (!rig->simulated)
    if (const auto holder = drivers::ChamberLock::holder(run::chamber_lock_name(*rig)))
      return failure(FaultKind::refused, rig->file, "the chamber is in use: " + holder->words);
  list_waiting_guards(*rig, found);
  found.words += relay_line(*rig);
  const auto answers = query_instruments(*rig, options.seed, found.controller);
  if (!answers) return failure(answers.error());
  for (const auto& answer : answers->all) found.words += "  " + answer + "\n";
  found.json["instruments"] = answers->all;
  found.fault = answers->fault;
  return rig;
}

/// Adds the releases of profile and rig to the findings, if the site has a register. Fails if a run would not start.
Result<void> state_releases(const profile::Profile& profile, const rig::RigFile& rig, Findings& found) {
  const auto releases = check_releases(profile, rig);
  if (!releases) return failure(releases.error());
  for (const auto& release : *releases) {
    found.words += "  " + describe(release) + "\n";
    found.json["releases"].push_back({{"title", release.title},
                                      {"sha256", release.sha256},
                                      {"revision", release.revision},
                                      {"released_by", release.released_by},
                                      {"unreleased", release.unreleased}});
  }
  return {};
}

Result<Exit> check(Console& console, const CheckArguments& options) {
  if (options.profile.empty() && options.rig.empty())
    return failure(FaultKind::usage, "check", "nothing to check; expected a profile, --rig or both");
  if (options.connect && options.rig.empty())
    return failure(FaultKind::usage, "--connect", "expected --rig with the rig to connect to");
  Findings found;
  std::optional<rig::RigFile> rig;
  if (!options.rig.empty()) {
    auto checked = check_rig(options, found);
    if (!checked) return failure(checked.error());
    rig = std::move(*checked);
  }
  if (found.fault) {  // print all findings before the fault
    console.print_report(console.json ? json_text(found.json) + "\n" : found.words);
    return failure(*found.fault);
  }
  if (rig && options.profile.empty())
    if (const auto taken = check_controller(found.controller, {}, *rig); !taken) return failure(taken.error());
  if (!options.profile.empty()) {
    const auto profile = read_profile(options.profile, rig ? &*rig : nullptr);
    if (!profile) return failure(profile.error());
    if (auto accepted = check_accept(*profile, options.profile); !accepted) return failure(accepted.error());
    if (rig)
      if (const auto taken = check_controller(found.controller, *profile, *rig); !taken) return failure(taken.error());
    const auto timeline = plan(*profile);
    const auto set_points = run::count_set_points(*profile, rig ? rig->chamber_limits : profile::ChamberLimits{},
                                                  rig ? rig->chamber_map.limits.every : Duration{});
    if (rig)
      if (const auto stated = state_releases(*profile, *rig, found); !stated) return failure(stated.error());
    found.words += describe(*profile, timeline) + set_point_lines(set_points, rig ? &*rig : nullptr);
    found.json["profile"] = timeline_json(*profile, timeline);
    found.json["profile"]["set_points"] = set_points;
    if (rig) {
      const auto reached = list_reached_limits(*profile, *rig);
      for (const auto& sentence : reached) found.words += fmt::format("  WARNING: {}\n", sentence);
      found.json["profile"]["reached_limits"] = reached;
    }
    if (rig && rig->chamber_map.limits.nonvolatile > 0)
      found.json["profile"]["nonvolatile_set_points"] = rig->chamber_map.limits.nonvolatile;
  }
  console.print_report(console.json ? json_text(found.json) + "\n" : found.words);
  return Exit::done;
}

}  // namespace

void add_check(Program& program) {
  auto [command, options] =
      add_command(program, "check", "Checks a profile, a rig, or a profile against a rig; prints the timeline.",
                  "gyrotherm check qualification --rig virtual", check);
  command.add_option("profile", options.profile, "the profile")->type_name(value::kProfile);
  command.add_option("--rig", options.rig, "the rig")->type_name(value::kRig);
  command.add_flag("--connect", options.connect, "identify each instrument and read it a few times");
  command.add_option("--seed", options.seed, "seed of a virtual rig")->check(not_negative());
}

}  // namespace gyrotherm::app
