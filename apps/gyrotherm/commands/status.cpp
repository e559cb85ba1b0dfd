// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/status.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <sstream>
#include <thread>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_source.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/run/operator_mark.hpp"
#include "core/clock.hpp"
#include "core/count_text.hpp"
#include "core/json.hpp"
#include "sequencer/run/run_tally.hpp"
#include "sequencer/watchdog/guard_post.hpp"
#include "sequencer/watchdog/safe_state_file.hpp"

namespace gyrotherm::app {
namespace {

std::string degrees(const std::optional<Celsius>& value) {
  return value ? fmt::format("{:.2f} °C", value->value) : "unknown";
}

/// Returns whether the record was imported: it has no profile. A run that waits for serial numbers has none yet.
bool is_imported(const record::RunStatus& status) {
  return status.segment_count == 0 && status.overview.state != RunState::held;
}

/// Returns whether the record of a real run does not state that the run was held or aborted, or how it ended.
bool is_end_lost(const record::RunStatus& status) {
  if (!has_lost_end(status.path, !status.ended_by.empty())) return false;
  const auto info = record::read_info(status.path);
  return info && !info->virtual_rig;
}

/// Returns whether an operator must check the chamber before this run is resumed.
bool needs_operator(const record::RunStatus& status) {
  const auto state = status.overview.state;
  return state == RunState::held || state == RunState::aborting || state == RunState::aborted || is_end_lost(status);
}

std::string describe_state(const record::RunStatus& status) {
  if (is_imported(status)) return "an import of " + format_count(status.slot + 1, "row");
  if (status.finished) return "finished";
  if (status.being_written) return "running";
  if (!needs_operator(status)) return "not finished; \"gyrotherm resume\" continues the run";
  return fmt::format("not finished; check the chamber, then run \"gyrotherm resume {} --accept\"", status.path);
}

/// Returns one line per alarm. Consequential alarms follow their root cause. The shelved ones are the last group.
std::string alarm_lines(const record::RunStatus& status) {
  std::string text;
  for (const auto& alarm : status.alarms) {
    const bool is_consequence = !alarm.suppressed_by.empty();
    const auto times =
        alarm.count > 1 ? fmt::format(", {} times since {}", alarm.count, civil_time(alarm.first_utc)) : "";
    const auto* kind = is_consequence ? "  consequence" : alarm.is_shelved() ? "shelved alarm" : "ALARM";
    text += fmt::format("  {} {} ({}, {} priority), {}{}: {}\n", kind, alarm.number, describe_alarm_state(alarm),
                        name(alarm.priority), civil_time(alarm.utc), times, alarm.text);
    if (alarm.is_shelved()) text += fmt::format("    {}\n", describe_shelving(alarm));
  }
  if (const auto open = count_unacknowledged(status.alarms); open > 0 && status.being_written)
    text += fmt::format("  {} unacknowledged: gyrotherm tell RUN.db acknowledge NUMBERS|all \"COMMENT\"\n", open);
  return text;
}

/// Describes the progress of a run and its faults.
std::string state_lines(const record::RunStatus& status) {
  const RunOverview& overview = status.overview;
  const bool has_stopped = !status.being_written && !status.finished;
  auto text =
      fmt::format("  {}{}\n", has_stopped ? "last state: " : "", record::describe(overview.state, overview.cause));
  if (overview.state == RunState::held && status.being_written)
    text += "  \"gyrotherm tell RUN.db resume\" continues the run\n";
  if (overview.time_left)
    text += fmt::format("  {} left{}", format_duration(*overview.time_left),
                        is_in_virtual_time(status) ? " in simulated time" : "");
  if (overview.time_left && overview.behind_plan)
    text += fmt::format(", {} behind plan", format_duration(*overview.behind_plan));
  if (overview.time_left) text += "\n";
  if (overview.missed_set_points > 0)
    text += fmt::format("  {} set points were not accepted by the chamber\n", overview.missed_set_points);
  if (overview.unconfirmed_set_points > 0)
    text += fmt::format("  {} set points were not confirmed in time; the chamber may have taken them\n",
                        overview.unconfirmed_set_points);
  for (const auto& fault : overview.faults_now)
    text += fmt::format("  {}fault: {}\n", has_stopped ? "last " : "", fault);
  text += alarm_lines(status);
  if (!status.ended_by.empty()) text += fmt::format("  ended by: {}\n", status.ended_by);
  if (status.backlog_s > 0) text += fmt::format("  {} s are waiting for the disk\n", status.backlog_s);
  if (!status.storage_trouble.empty()) text += fmt::format("  no rows can be written: {}\n", status.storage_trouble);
  if (!status.record_damage.empty()) text += fmt::format("  DAMAGED: {}\n", status.record_damage);
  for (const auto& part : status.parts) text += fmt::format("  continued in {}\n", part);
  return text;
}

/// Returns whether the program that executes the run is alive, according to the age of the status file. Returns nothing
/// if the record is not being written.
std::optional<bool> is_alive(const record::RunStatus& status) {
  if (!status.being_written) return {};
  const auto age = status_age(status);
  return age && *age <= record::kSilentAfter;
}

/// Returns the last status file of a run that no program executes.
std::optional<record::RunStatus> read_last_file(const record::RunStatus& status) {
  auto last = record::read_status_file_if_any(status.path);
  return last && last->id == status.id ? std::move(last) : std::nullopt;
}

/// Returns the age of the values in a status. For a run that no program executes, this is the age of its status file.
std::optional<Duration> find_age(const record::RunStatus& status) {
  if (status.being_written || status.finished) return status_age(status);
  const auto last = read_last_file(status);
  return last ? status_age(*last) : std::nullopt;
}

std::string age_line(const record::RunStatus& status) {
  const auto age = find_age(status);
  if (!status.being_written && !status.finished && !is_imported(status))
    return fmt::format("  no program executes this run; the following was read {}\n",
                       age ? format_duration(*age) + " ago" : "at an unknown time");
  if (!status.being_written) return {};
  const auto ago =
      age ? fmt::format("written {} ago", format_duration(*age)) : "written before the machine was last started";
  if (is_alive(status).value_or(true)) return fmt::format("  {}\n", ago);
  return fmt::format("  WARNING: {}: the program or its disk does not respond; the following is the last known state\n",
                     ago);
}

/// Returns the set point of the profile, and that of the chamber if it differs.
std::string describe_set_points(const record::RunStatus& status) {
  constexpr Kelvins kSame{0.15};  // a controller rounds to 0.1 K
  const auto& of_profile = status.set_point;
  const auto& of_chamber = status.chamber_set_point;
  if (!of_chamber && !status.chamber_air && status.slot >= 0)
    return fmt::format("set point of the profile {}, of the chamber unknown", degrees(of_profile));
  if (!of_chamber || (of_profile && abs(*of_profile - *of_chamber) <= kSame)) return "set point " + degrees(of_profile);
  return fmt::format("set point of the profile {}, of the chamber {}", degrees(of_profile), degrees(of_chamber));
}

std::string thermometer_line(const record::RunStatus& status) {
  std::string text;
  for (const auto& [channel, reading] : status.thermometers) text += fmt::format(" {} {}", channel, degrees(reading));
  return text + "\n";
}

/// Reads the description of the run, also while the run is active. Returns nothing if it cannot be read now.
std::optional<record::RunInfo> read_units(const record::RunStatus& status) {
  const auto info = record::find_source_files(status.path, status.being_written).and_then(record::read_source_info);
  return info ? std::optional(*info) : std::nullopt;
}

/// Describes the units that are identified: "  units: u1 0042, u2 empty; order 2026-17".
std::string units_line(const record::RunStatus& status) {
  const auto info = read_units(status);
  if (!info) return {};
  std::string units;
  for (const auto& unit : info->units) {
    const auto number = is_unused(*info, unit.name) ? "empty" : unit.serial_number;
    if (!number.empty()) units += fmt::format("{}{} {}", units.empty() ? "" : ", ", unit.name, number);
  }
  if (!info->order_number.empty()) units += fmt::format("{}order {}", units.empty() ? "" : "; ", info->order_number);
  return units.empty() ? "" : fmt::format("  units: {}\n", units);
}

/// Returns the position in the profile: with the phase while the profile commands the chamber, and otherwise the
/// segment in which it has ended.
std::string segment_line(const record::RunStatus& status) {
  if (status.segment_count == 0) return {};
  const auto state = status.overview.state;
  if (status.finished && state == RunState::complete)
    return fmt::format("  {} done\n", format_count(status.segment_count, "segment"));
  const auto position = fmt::format("segment {} of {}", status.segment_index + 1, status.segment_count);
  if (status.being_written && !has_left_profile(state))
    return fmt::format("  {}, {}: {}\n", position, status.segment, name(status.phase));
  return fmt::format("  {} in {}, {}\n", has_left_profile(state) ? "ended" : "interrupted", position, status.segment);
}

std::string describe(const record::RunStatus& status) {
  auto text = fmt::format("{}{}: {}\n", status.simulated ? "SIMULATED " : "", status.path, describe_state(status));
  text += age_line(status);
  if (!status.virtual_instruments.empty())
    text +=
        fmt::format("  SIMULATED: these instruments are virtual: {}\n", fmt::join(status.virtual_instruments, ", "));
  if (!status.unreleased.empty()) text += fmt::format("  UNRELEASED: {}\n", fmt::join(status.unreleased, ", "));
  text += units_line(status);
  if (is_imported(status)) return text + " " + thermometer_line(status);
  text += fmt::format("  up to second {}, acknowledged up to {}, {}\n", status.slot, status.acknowledged,
                      run::describe_faults(status.faults - status.faults_while_off, status.faults_while_off));
  text += segment_line(status) + state_lines(status);
  if (status.decision) text += fmt::format("  {}\n", describe_progress(*status.decision, status.slot + 1));
  if (const auto& frames = status.frames)
    text += fmt::format("  gyro frames: {} received, {} lost, {} bad\n", frames->seen, frames->lost, frames->bad);
  for (const auto& axis : status.gyro_rates) text += "  " + describe(axis) + "\n";
  text += fmt::format("  {}, air {}\n ", describe_set_points(status), degrees(status.chamber_air));
  return text + thermometer_line(status);
}

/// Returns the guards that make the chamber of this dead run safe, or wait for it.
std::vector<watchdog::WaitingGuard> find_guards(const std::string& path) {
  std::error_code error;
  const auto record = std::filesystem::absolute(path, error).lexically_normal();
  auto guards = watchdog::find_waiting_guards();
  std::erase_if(guards,
                [&](const auto& guard) { return std::filesystem::path(guard.record).lexically_normal() != record; });
  return guards;
}

/// Returns the status as JSON, with the trace of gyrotherm-make-safe. The trace is null if that program did not act.
std::string to_json(const record::RunStatus& status, const std::optional<watchdog::MadeSafe>& guard) {
  auto json = Json::parse(to_json(status));
  const auto age = find_age(status);
  const auto alive = is_alive(status);
  json["written_ago_s"] = age ? Json(to_seconds(*age)) : nullptr;
  json["answers"] = alive ? Json(*alive) : nullptr;
  json["units"] = Json::array();
  json["order_number"] = "";
  if (const auto info = read_units(status)) {
    json["order_number"] = info->order_number;
    for (const auto& unit : info->units)
      json["units"].push_back({{"name", unit.name},
                               {"serial_number", unit.serial_number},
                               {"model", unit.model},
                               {"in_use", !is_unused(*info, unit.name)}});
  }
  json["made_safe"] = nullptr;
  if (guard)
    json["made_safe"] = {{"at", civil_time(guard->at)},
                         {"because", guard->because},
                         {"set_point_c", guard->set_point.value},
                         {"confirmed", guard->confirmed},
                         {"details", guard->details}};
  json["guards"] = Json::array();
  for (const auto& waiting : find_guards(status.path)) json["guards"].push_back(waiting.pid);
  return json_text(json) + "\n";
}

/// Adds the faults that the program of a dead run stated last, such as an open relay. Its record has no such list.
void add_last_faults(record::RunStatus& status) {
  if (status.being_written || status.finished || !status.ended_by.empty()) return;
  if (auto last = read_last_file(status)) status.overview.faults_now = std::move(last->overview.faults_now);
}

/// Reads the status of a run. A run that waits for serial numbers has no record yet, only a status file.
Result<record::RunStatus> read_present_status(const std::string& path) {
  auto status = record::read_status(path);
  if (status) {
    add_last_faults(*status);
    return status;
  }
  auto fresh = record::read_fresh_status(path);
  return fresh ? Result<record::RunStatus>(std::move(*fresh)) : status;
}

/// Returns a line per guard of a dead run, or a warning if no guard is left and nothing shows a safe chamber.
std::string guard_lines(const record::RunStatus& status) {
  std::string text;
  for (const auto& guard : find_guards(status.path))
    text += fmt::format("  guard: process {} makes the chamber safe, waits until it can, or waits for the disk\n",
                        guard.pid);
  const bool is_dead = !status.being_written && !status.finished;
  if (text.empty() && is_dead && record::path_exists(watchdog::safe_state_path(status.path)))
    text = fmt::format(
        "  WARNING: no guard is left, and nothing shows that the chamber was made safe; run "
        "\"gyrotherm-make-safe {0}\" or \"gyrotherm resume {0}{1}\"\n",
        status.path, needs_operator(status) ? " --accept" : "");
  return text;
}

Result<Exit> print_status(Console& console, const std::string& path) {
  const auto status = read_present_status(path);
  if (!status) return failure(status.error());
  const auto guard = watchdog::read_trace(path);
  if (!guard) return failure(guard.error());
  if (console.json)
    console.print(to_json(*status, *guard));
  else
    console.print_report(describe(*status) + guard_lines(*status) + (*guard ? "  " + describe(**guard) + "\n" : ""));
  if (!status->being_written && !status->finished)
    if (const auto files = record::find_record_files(path)) warn_of_missing_files(console, *files);
  return Exit::done;
}

/// Describes the manifest of a verified record. An unfinished record has none.
const char* describe_manifest(const record::Verified& verified) {
  if (verified.manifest) return " and the file matches its manifest";
  return verified.finished ? "; it has no manifest, although its run is finished" : "";
}

/// Verifies the record. A record that is being written is not opened.
Result<Exit> verify(Console& console, const std::string& path) {
  const auto files = record::find_record_files(path);
  const auto verified = files ? record::verify_record(*files) : failure(files.error());
  if (!verified) return failure(verified.error());
  warn_of_missing_files(console, *files);
  console.print_report(console.json
                           ? fmt::format("{{\"rows\": {}, \"files\": {}, \"finished\": {}, \"manifest\": {}}}\n",
                                         verified->rows, verified->files, verified->finished, verified->manifest)
                           : fmt::format("{}: verified, all {} rows are unchanged{}\n", path, verified->rows,
                                         describe_manifest(*verified)));
  return Exit::done;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream all(text);
  for (std::string line; std::getline(all, line);) lines.push_back(line);
  return lines;
}

/// Prints the status each second until the record is closed. The last status remains on the terminal.
Result<Exit> watch(Console& console, const std::string& path) {
  constexpr int kPollsPerSecond = 10;
  watch_for_interrupts(SecondInterrupt::ends);
  for (;;) {
    const auto status = read_present_status(path);
    if (!status) return failure(status.error());
    const bool is_active = status->being_written && !interrupted();
    if (!is_active || console.json || !console.redraws())
      (void)print_status(console, path);
    else
      console.panel([&] { return split_lines(describe(*status)); }, true);
    if (!is_active || console.has_lost_data()) return Exit::done;
    for (int i = 0; i < kPollsPerSecond && !interrupted(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1000 / kPollsPerSecond));
  }
}

struct StatusArguments {
  std::string run;
  bool verify = false;
  bool watch = false;
};

Result<Exit> show_or_verify(Console& console, const StatusArguments& options) {
  if (options.watch && options.verify) return failure(FaultKind::usage, "--watch", "not valid with --verify");
  if (options.verify) return verify(console, options.run);
  const auto record = record::record_of_copy(options.run);  // only the record's status is current
  return options.watch ? watch(console, record) : print_status(console, record);
}

}  // namespace

void add_status(Program& program) {
  auto [command, options] = add_command(program, "status", "Prints the state of a run; safe while it is running.",
                                        "gyrotherm status random.db", show_or_verify);
  command.add_option("run", options.run, "the record")->type_name(value::kRecord)->required();
  command.add_flag("--watch", options.watch,
                   "refresh every second until the run has ended; with --json one line per second");
  command.add_flag("--verify", options.verify, "verify the record against its hash chain and its manifest");
}

}  // namespace gyrotherm::app
