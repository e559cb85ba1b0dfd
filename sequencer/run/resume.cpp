// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/resume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <utility>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "drivers/chamber/register_map.hpp"
#include "sequencer/profile/released_blocks.hpp"
#include "sequencer/rig/unit_serials.hpp"
#include "sequencer/run/dropped_units.hpp"

namespace gyrotherm::run {

namespace {

std::string make_random_id() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", device(), device(), device(), device());
}

std::string derive_id(const record::RunInfo& info, const rig::UnitIdentification& units) {
  auto all = fmt::format("{}\n{}\n{}\n{}\n{}\n{}", info.program_version, info.profile_text, info.rig_text,
                         info.chamber_map_text, info.gyro_model_text, info.seed);
  const auto day = info.days_later == 0 ? "" : fmt::format("\n{} days later", info.days_later);
  for (const auto& unit : info.units)
    if (!unit.stream_text.empty()) all += "\n" + unit.stream_text;
  for (const auto& map : info.analogue_map_texts) all += "\n" + map;
  for (const auto& description : info.thermometer_texts) all += "\n" + description;
  for (const auto& [unit, serial] : units.serial_numbers) all += fmt::format("\n{} {}", unit, serial);
  for (const auto& unit : units.unused) all += fmt::format("\n{} not used", unit);
  if (!units.order_number.empty()) all += "\norder " + units.order_number;
  for (const auto& description : info.supply_texts) all += "\n" + description;
  if (const auto& goal = info.goal)
    all += fmt::format("\nuntil {} {}\n{}\n{}", goal->u_deg_per_h, goal->mission_name, goal->mission_text,
                       goal->prior_text);
  return sha256(all + day).substr(0, 32);
}

}  // namespace

record::RunInfo::SegmentInfo describe_segment(const profile::Segment& segment) {
  return {.name = segment.name,
          .hold = segment.kind == profile::SegmentKind::hold,
          .target = segment.target,
          .rate = segment.rate,
          .cycle = segment.cycle,
          .prompt = segment.prompt,
          .unit = segment.unit};
}

record::RunInfo run_info(std::string_view program_version, const profile::Profile& profile, const rig::RigFile& rig,
                         std::uint64_t seed, Duration started_utc, std::uint64_t days_later,
                         const std::optional<record::RunInfo::Goal>& goal) {
  record::RunInfo info;
  info.goal = goal;
  info.program_version = program_version;
  info.profile_name = profile.name;
  info.profile_text = profile.text;
  info.rig_name = rig.name;
  info.rig_text = rig.text;
  std::error_code error;
  if (!rig.simulated) info.rig_file = std::filesystem::absolute(rig.file, error).lexically_normal().string();
  info.chamber_map_text = rig.chamber_map.text;
  info.analogue_map_texts = collect_analogue_map_texts(rig);
  info.thermometer_texts = collect_thermometer_texts(rig);
  info.supply_texts = collect_supply_texts(rig);
  info.gyro_model = rig.gyro_model.name;
  info.gyro_film = rig.gyro_model.film;
  info.gyro_model_text = rig.gyro_model.text;
  info.virtual_rig = rig.simulated;
  info.seed = seed;
  info.days_later = days_later;
  info.started_utc = started_utc;
  info.has_humidity = records_humidity(rig);
  info.has_dew_point = records_dew_point(rig);
  info.thermometers = list_channels(rig);
  info.chamber_instrument = fmt::format("{} at {}", rig.chamber_map.name, rig.chamber_line);
  for (const auto& unit : rig.units) info.units.push_back(unit.info);
  info.order_number = rig.identification.order_number;
  info.unused_units = rig.identification.unused;
  info.cycles = profile.cycles;
  for (const auto& segment : profile.segments) info.segments.push_back(describe_segment(segment));
  if (const auto& added = profile.warm_up)
    info.warm_up = {.at_least = added->at_least, .air = added->air, .rate = added->rate};
  info.id = rig.simulated ? derive_id(info, rig.identification) : make_random_id();
  return info;
}

Result<void> add_recorded_warm_ups(profile::Profile& profile, const record::RunInfo& info) {
  if (!info.warm_up) return {};
  return profile::add_warm_ups(
      profile, {.at_least = info.warm_up->at_least, .air = info.warm_up->air, .rate = info.warm_up->rate});
}

drivers::PowerDemand power_at_start(const profile::Profile& profile) {
  return profile.segments.front().unit.off ? drivers::PowerDemand::keep : drivers::PowerDemand::on;
}

std::uint64_t run_number(const std::string& profile_text) {
  constexpr int kHexadecimal = 16;
  return std::stoull(sha256(profile_text).substr(0, 16), nullptr, kHexadecimal);
}

namespace {

/// Longest replay of a virtual rig, in seconds: four months.
constexpr std::int64_t kMaxReplayed = 10'000'000;

UnitState unit_at(const record::Record& record, std::size_t row) {
  const auto* segment = segment_at(record, row);
  return segment != nullptr ? segment->unit : UnitState{};
}

/// Updates the state of each output of the supplies, in order, from the voltage that was measured in a row. An unread
/// output keeps its state.
void update_powered(const record::Record& record, const rig::RigFile& rig, std::size_t row,
                    std::vector<bool>& powered) {
  std::size_t next = 0;
  for (const auto& supply : rig.supplies)
    for (const auto& output : supply.outputs) {
      const auto index = next++;
      const auto& fed = output.shares.front();
      const auto& values = record.units[fed.unit].values;
      const auto sent = values.size() - rig.units[fed.unit].analogue_values;
      const double voltage_v = values[sent + fed.voltage][row];
      if (!std::isnan(voltage_v)) powered[index] = voltage_v > output.settings.voltage_v / 2;
    }
}

/// Returns the state of each output at the start: a virtual supply starts with its outputs on.
std::vector<bool> all_powered(const rig::RigFile& rig) {
  std::vector<bool> powered;
  for (const auto& supply : rig.supplies) powered.resize(powered.size() + supply.outputs.size(), true);
  return powered;
}

/// Returns every second up to and including `last`: the set point that the chamber reported, or the profile's set point
/// if the chamber was silent, and the state of the unit and its power at the end of the previous second. A gap has the
/// set point of the second that ended it.
std::vector<simulator::PastSecond> list_seconds(const record::Record& record, const rig::RigFile& rig,
                                                std::int64_t last) {
  std::vector<simulator::PastSecond> seconds;
  UnitState unit;
  auto powered = all_powered(rig);
  for (std::size_t i = 0; i < record.slot.size() && record.slot[i] <= last; ++i) {
    const auto read_back = record.chamber_set_point_c[i];
    const Celsius set_point{std::isnan(read_back) ? record.set_point_c[i] : read_back};
    seconds.resize(static_cast<std::size_t>(record.slot[i] + 1), {set_point, unit, powered});
    unit = unit_at(record, i);
    update_powered(record, rig, i, powered);
  }
  return seconds;
}

/// Returns every past second of the virtual world: the first preparation, the recorded seconds and the gap. The second
/// that the new preparation takes is not included.
std::vector<simulator::PastSecond> make_replay(const record::Record& record, const RunContinuation& on) {
  if (on.last_slot < 0) return {};
  auto seconds = list_seconds(record, on.rig, on.last_slot);
  seconds.insert(seconds.begin(), seconds.front());  // slot 0 shows the prepared state
  // The last second sent the next set point only if the chamber had accepted the previous one.
  const auto before = seconds.back().set_point;
  const bool followed = abs(before - Celsius{record.set_point_c.back()}) <= set_point_tolerance(on.rig.chamber_map);
  simulator::PastSecond held{followed ? demanded_set_point(on.profile, on.state) : before,
                             unit_at(record, record.slot.size() - 1), seconds.back().powered};
  update_powered(record, on.rig, record.slot.size() - 1, held.powered);
  seconds.resize(seconds.size() + static_cast<std::size_t>(on.interruption.down / kSecond) - 1, held);
  return seconds;
}

/// Returns the coldest calibrated reading in the record's last second; nothing if no thermometer was read.
std::optional<Celsius> coldest_last_reading(const record::Record& record) {
  std::optional<Celsius> coldest;
  for (std::size_t i = 0; i < record.info.thermometers.size(); ++i) {
    const auto reading = record::celsius_if_known(record.thermometers_c[i].back());
    if (!reading) continue;
    const auto value = record::calibrated(record.info.thermometers[i], *reading);
    if (!coldest || value < *coldest) coldest = value;
  }
  return coldest;
}

/// Returns the reading of the soak sensor in the record's last second, or nothing if it was not read.
std::optional<Celsius> last_soak_reading(const record::Record& record, const std::string& sensor) {
  if (sensor == profile::kColdestThermometer) return coldest_last_reading(record);
  if (sensor == "air") return record::celsius_if_known(record.chamber_air_c.back());
  const auto channel = std::ranges::find(record.info.thermometers, sensor, &record::Channel::name);
  if (channel == record.info.thermometers.end()) return std::nullopt;
  const auto column = static_cast<std::size_t>(channel - record.info.thermometers.begin());
  const auto reading = record::celsius_if_known(record.thermometers_c[column].back());
  return reading ? std::optional(record::calibrated(*channel, *reading)) : std::nullopt;
}

/// Returns the profile's state one second after the last recorded second. The profile's clock runs only in Execute. A
/// soak with a slope limit does not include that second, because the slope was not recorded. If a deadline ended the
/// run, the segment's deadline starts again; otherwise the resumed run would end in its first second.
Result<profile::ProfileState> state_after(const record::Record& record, const profile::Profile& profile,
                                          RunState last_state) {
  if (record.slot.empty()) return begin(profile);
  const auto last = restore_state(profile, record.progress.back());
  if (!last) return last;
  if (last_state != RunState::execute) return profile::restart_deadline(*last);
  return next(profile, *last, {.elapsed = kSecond, .air = last_soak_reading(record, soak_sensor(profile, *last))});
}

/// Returns the last air temperature that was read in Execute. The air of a run that is returning to the profile is not
/// a valid reference.
std::optional<Celsius> last_air_in_execute(const record::Record& record) {
  for (auto row = record.state.size(); row-- > 0;)
    if (record.state[row] == RunState::execute && !std::isnan(record.chamber_air_c[row]))
      return Celsius{record.chamber_air_c[row]};
  return std::nullopt;
}

std::map<std::string, std::string> stream_texts(const record::RunInfo& info) {
  std::map<std::string, std::string> streams;
  for (const auto& unit : info.units)
    if (!unit.stream_text.empty()) streams.emplace(unit.name, unit.stream_text);
  return streams;
}

/// Returns true if a foreign set point was active when the last program of the run ended.
bool had_foreign_set_point(const record::Record& record) {
  bool is_active = false;
  for (const auto& [slot, event] : record.events) {
    const bool is_about_it = event.about.interlock == name(interlocks::InterlockId::foreign_set_point) ||
                             event.about.interlock == name(interlocks::InterlockId::not_following);
    if (event.kind == EventKind::resumed || (is_about_it && event.kind == EventKind::recovered)) is_active = false;
    if (is_about_it && (event.kind == EventKind::interlock || event.kind == EventKind::fault)) is_active = true;
  }
  return is_active;
}

/// The last state of a run, and the reason why it ended.
struct Ending {
  RunState state{};
  std::string why = "the program ended without stating a reason";
  bool is_recorded = false;
};

/// Returns the last event that states why the run ended, if it was not resumed afterwards. Notes may follow it.
const Event* find_last_cause(const record::Record& record) {
  for (auto event = record.events.rbegin(); event != record.events.rend(); ++event) {
    const auto& one = event->event;
    if (one.kind == EventKind::started || one.kind == EventKind::resumed) return nullptr;
    const bool aborts = one.about.reaction.empty() || one.about.reaction == name(interlocks::Reaction::abort);
    if (one.kind == EventKind::interrupted || (one.kind == EventKind::interlock && aborts)) return &one;
  }
  return nullptr;
}

Ending read_ending(const record::Record& record) {
  Ending ending;
  if (!record.state.empty()) ending.state = record.state.back();
  if (record.events.empty()) return ending;
  const auto& last = record.events.back().event;
  // Early records contain neither states nor reactions; they end with the interlock.
  const bool is_early_format = last.about.reaction.empty();
  if (ending.state == RunState::execute && last.kind == EventKind::interlock && is_early_format)
    ending.state = RunState::aborted;
  const auto* cause = find_last_cause(record);
  if (cause != nullptr && (cause->kind == EventKind::interrupted || ending.state == RunState::aborted)) {
    ending.why = cause->text;
    ending.is_recorded = true;
  } else if (ending.state != RunState::execute) {
    const auto reported = std::find_if(record.events.rbegin(), record.events.rend(),
                                       [](const auto& event) { return event.event.kind == EventKind::state; });
    if (reported != record.events.rend()) ending.why += "; it was " + reported->event.text;
  }
  return ending;
}

}  // namespace

std::string compare_identities(const std::map<std::string, std::string>& at_start,
                               const std::map<std::string, std::string>& now) {
  std::vector<std::string> all;
  for (const auto& [title, identity] : now)
    if (const auto before = at_start.find(title); before != at_start.end() && before->second != identity)
      all.push_back(fmt::format("{}: another instrument, or other settings: {}; the run began with: {}", title,
                                identity, before->second));
  return fmt::format("{}", fmt::join(all, "; "));
}

ReentryDecision judge_reentry(const InterruptedRun& interrupted, Celsius mild, Celsius air_now) {
  if (!interrupted.mismatched_instruments.empty()) return {Reentry::ask, interrupted.mismatched_instruments};
  if (interrupted.aborted) return {Reentry::ask, "the run was aborted"};
  if (interrupted.held) return {Reentry::ask, "the run was held"};
  if (interrupted.end_lost)
    return {Reentry::ask,
            "the record does not state how the run ended; its last rows were not written, or its files were moved"};
  if (interrupted.foreign) return {Reentry::ask, "another program or a person had changed the chamber"};
  if (!interrupted.given_up.empty())
    return {Reentry::ask, "the guard was ordered to give up by " + interrupted.given_up};
  if (interrupted.found_off) return {Reentry::ask, "the chamber is switched off; a person may be working in it"};
  if (!interrupted.why_unknown.empty()) return {Reentry::ask, interrupted.why_unknown};
  if (interrupted.down > kLongestUnattended)
    return {Reentry::ask, fmt::format("down for {}, longer than {}", format_duration(interrupted.down),
                                      format_duration(kLongestUnattended))};
  if (!interrupted.why_asks.empty()) return {Reentry::ask, interrupted.why_asks};
  const auto lowest = std::min(interrupted.lowest, mild) - kResumeBand;
  const auto highest = std::max(interrupted.highest, mild) + kResumeBand;
  if (air_now < lowest || air_now > highest)
    return {Reentry::ask, fmt::format("the air is at {:.2f} °C, outside the segment's {:g} … {:g} °C", air_now.value,
                                      interrupted.lowest.value, interrupted.highest.value)};
  if (!interrupted.air)
    return {Reentry::stabilise,
            fmt::format("the air is at {:.2f} °C; it was unknown before the interruption", air_now.value)};
  if (abs(air_now - *interrupted.air) > kResumeBand)
    return {Reentry::stabilise, fmt::format("the air is at {:.2f} °C; it was at {:.2f} °C before the interruption",
                                            air_now.value, interrupted.air->value)};
  return {};
}

std::string unknown_downtime_reason(Duration down) {
  constexpr Duration kCorrection = 2 * kSecond;  // tolerated error of the clock
  if (down < -kCorrection)
    return fmt::format("the clock is {} behind the last second of the record: the downtime is unknown",
                       format_duration(-down));
  if (down > kLongestBelieved)
    return fmt::format("by the clock it was down for {} days, which is implausible: the downtime is unknown",
                       std::chrono::floor<std::chrono::days>(down).count());
  return "";
}

std::string describe_downtime(const InterruptedRun& interrupted) {
  return interrupted.why_unknown.empty() ? format_duration(interrupted.down) : "an unknown time";
}

bool is_in_place(Celsius air, Celsius goal, const std::optional<Celsius>& air_before) {
  return abs(air - goal) <= kResumeBand || (air_before && abs(air - *air_before) <= kResumeBand);
}

EntryPoint entry_at(Celsius goal, Celsius air_now, bool air_in_place, const profile::ChamberLimits& limits) {
  if (air_in_place) return {.set_point = goal};
  return {.set_point = std::clamp(air_now, limits.lowest, limits.highest), .away = true};
}

EntryPoint avoid_step(const EntryPoint& entry, const ChamberState& found, const profile::ChamberLimits& limits,
                      EntryClock clock) {
  constexpr Kelvins kResolution{0.1};  // resolution of common controllers
  const auto is_step_from = [&](Celsius from) {
    const auto& rate = entry.set_point > from ? limits.fastest_heating : limits.fastest_cooling;
    return !(abs(entry.set_point - from) <= std::max(rate * Duration(kSecond), kResolution));
  };
  const bool shows = found.activity == ChamberActivity::running || found.activity == ChamberActivity::unknown;
  if (entry.away || !is_step_from(found.air) || (shows && !is_step_from(found.set_point))) return entry;
  const bool continues = clock == EntryClock::runs && abs(entry.set_point - found.air) <= kResumeBand;
  return {std::clamp(found.air, limits.lowest, limits.highest), !continues, continues};
}

SegmentExtremes segment_extremes(const profile::Profile& profile, const profile::ProfileState& state) {
  const auto index = static_cast<std::size_t>(profile_position(profile, state).segment);
  const auto& segment = profile.segments[index];
  const auto from = segment.kind == profile::SegmentKind::ramp ? set_point_before(profile, index) : segment.target;
  return {std::min(from, segment.target), std::max(from, segment.target)};
}

Downtime compute_downtime(const record::Record& record, const std::optional<record::RunStatus>& status,
                          const MachineTime& now) {
  const auto last = record.slot.empty() ? std::int64_t{-1} : record.slot.back();
  const bool is_about_it = status && status->id == record.info.id;
  if (is_about_it && !now.boot.empty() && status->slot_in_boot == now.boot)
    return now.since_boot - status->slot_since_boot + kSecond * (status->slot - last);
  const auto down = now.utc - record.last_utc.value_or(record.info.started_utc);
  const auto duration = format_duration(std::max(down, Duration{}));
  if (is_about_it && down < now.since_boot)
    return {down, fmt::format("by the wall clock it was down for {}, but the machine was started {} ago", duration,
                              format_duration(now.since_boot))};
  const auto* cause = is_about_it ? "the machine was restarted meanwhile" : "there is no status file of this run";
  return {down, fmt::format("{}: it was down for {} according to the wall clock only", cause, duration)};
}

namespace {

Result<rig::RigFile> parse_recorded_rig(const record::RunInfo& info, const std::string& path) {
  return rig::parse_rig(info.rig_text, path + " (rig)",
                        {.chamber_map = info.chamber_map_text,
                         .gyro_model = info.gyro_model_text,
                         .gyro_streams = stream_texts(info),
                         .analogue_maps = info.analogue_map_texts,
                         .thermometer_descriptions = info.thermometer_texts,
                         .supply_descriptions = info.supply_texts,
                         .folder = info.rig_file.empty() ? std::string() : parent_folder(info.rig_file),
                         .channels = info.thermometers});
}

/// Fails with bad_file if the virtual rig cannot be replayed up to the record's end.
Result<void> check_replay(const record::RunInfo& info, bool simulated, std::int64_t last_slot,
                          const std::string& path) {
  if (info.days_later > simulator::kMaxDaysLater)
    return failure(
        FaultKind::bad_file, path,
        fmt::format("the gyro is {} days older, expected at most {}", info.days_later, simulator::kMaxDaysLater));
  if (simulated && last_slot > kMaxReplayed)
    return failure(
        FaultKind::bad_file, path,
        fmt::format("ends at second {}; at most {} seconds of a virtual rig can be replayed", last_slot, kMaxReplayed));
  return {};
}

/// Sets the downtime of a virtual rig: at least the one second that preparation takes, or zero if the run has no sample
/// yet.
void set_virtual_downtime(Duration down, bool has_begun, InterruptedRun& interrupted) {
  interrupted.down =
      has_begun ? Duration(std::chrono::floor<std::chrono::seconds>(std::max(down, kSecond))) : Duration{};
}

/// Sets the downtime of a real rig, and the reasons why an operator must confirm it. The run's clock continues during
/// the downtime, even before the first sample.
void set_real_downtime(const Downtime& downtime, InterruptedRun& interrupted) {
  interrupted.why_asks = downtime.why_asks;
  interrupted.why_unknown = unknown_downtime_reason(downtime.down);
  interrupted.down = interrupted.why_unknown.empty()
                         ? Duration(std::chrono::floor<std::chrono::seconds>(std::max(downtime.down, Duration{})))
                         : kSecond;
}

/// Collects the inputs of the resume rule. Uses profile, state, rig and last slot of `on`.
InterruptedRun describe_interruption(const record::Record& record, const RunContinuation& on, const Ending& ending,
                                     const Downtime& downtime) {
  const auto [lowest, highest] = segment_extremes(on.profile, on.state);
  InterruptedRun interrupted{.lowest = lowest,
                             .highest = highest,
                             .air = last_air_in_execute(record),
                             .aborted = ending.state == RunState::aborting || ending.state == RunState::aborted,
                             .end_recorded = ending.is_recorded,
                             .held = ending.state == RunState::held,
                             .foreign = had_foreign_set_point(record)};
  if (on.rig.simulated)
    set_virtual_downtime(downtime.down, on.last_slot >= 0, interrupted);
  else
    set_real_downtime(downtime, interrupted);
  return interrupted;
}

/// Returns the reason why a finished run cannot be resumed.
std::string finished_refusal(const record::Record& record) {
  const auto is_stop = [](const record::RecordedEvent& recorded) {
    return recorded.event.kind == EventKind::state && recorded.event.text.starts_with(name(RunState::stopped));
  };
  const auto stop = std::find_if(record.events.rbegin(), record.events.rend(), is_stop);
  const bool was_stopped = !record.state.empty() && record.state.back() == RunState::stopped;
  if (!was_stopped || stop == record.events.rend()) return "this run has finished; there is nothing to resume";
  return fmt::format(
      "this run was {}, at {}; a stop is final, so it cannot be resumed: start a new run. To go on "
      "later, end a run by Ctrl-C or pause it",
      stop->event.text, civil_time(stop->event.at.utc));
}

/// Returns the units that the run dropped, and those of empty positions.
std::vector<std::string> find_absent_units(const record::Record& record) {
  auto units = find_dropped_units(record);
  units.insert(units.end(), record.info.unused_units.begin(), record.info.unused_units.end());
  return units;
}

/// Returns the start parameters of the rig. Uses all members of `on` except `start`.
rig::RigStart plan_start(const record::Record& record, const RunContinuation& on, std::uint64_t run) {
  const auto since_last = on.last_slot + 1 + on.interruption.down / kSecond;
  return {.seed = {.gyro = record.info.seed, .run = run, .days_later = record.info.days_later},
          .elapsed = std::chrono::seconds(std::max(since_last, on.recorded + 1)),
          .replay = on.rig.simulated ? make_replay(record, on) : std::vector<simulator::PastSecond>(),
          .first_set_point = demanded_set_point(on.profile, begin(on.profile)),
          .units_may_be_off = unit_may_be_off(on.profile, on.state),
          .power = on.last_slot < 0 ? power_at_start(on.profile) : drivers::PowerDemand::keep,
          .dropped_units = find_absent_units(record)};
}

}  // namespace

Result<RunContinuation> plan_continuation(const record::Record& record, const std::string& path,
                                          const Downtime& downtime, std::uint64_t run) {
  if (record.finished) return failure(FaultKind::usage, path, finished_refusal(record));
  if (record.info.imported) return failure(FaultKind::usage, path, "an imported record cannot be resumed");
  auto rig = parse_recorded_rig(record.info, path);
  if (!rig) return failure(rig.error());
  restore_identification(*rig, record.info);
  auto profile = profile::parse_profile(record.info.profile_text, path + " (profile)");
  if (!profile) return failure(profile.error());
  if (!rig->supplies.empty())
    *profile = profile::switch_by_supplies(std::move(*profile), list_unfed_units(rig->supplies, rig->units));
  if (auto added = add_recorded_warm_ups(*profile, record.info); !added) return failure(added.error());
  if (auto added = profile::add_blocks(*profile, record.info.added_blocks); !added) return failure(added.error());
  const auto ending = read_ending(record);
  auto state = state_after(record, *profile, ending.state);
  if (!state) return failure(state.error());
  const auto last_slot = record.slot.empty() ? -1 : record.slot.back();
  if (auto good = check_replay(record.info, rig->simulated, last_slot, path); !good) return failure(good.error());

  RunContinuation on{.rig = std::move(*rig),
                     .profile = std::move(*profile),
                     .state = *state,
                     .last_slot = last_slot,
                     .recorded = record.gaps.empty() ? last_slot : std::max(last_slot, record.gaps.back().last),
                     .interruption = {},
                     .why_stopped = ending.why};
  on.interruption = describe_interruption(record, on, ending, downtime);
  on.start = plan_start(record, on, run);
  return on;
}

}  // namespace gyrotherm::run
