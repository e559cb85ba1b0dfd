// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/report/calibration_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "analysis/data/dataset.hpp"
#include "core/clock.hpp"
#include "core/sha256.hpp"
#include "sequencer/run/run_state_machine.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::size_t kDayLength = 10;  // length of "2026-11-25"

std::string utc_day(Duration utc) { return civil_time(utc).substr(0, kDayLength); }

std::string format_day_if_any(const std::optional<std::chrono::sys_days>& day) {
  return day ? record::format_day(*day) : std::string();
}

bool belongs_to(const record::Channel& channel, const std::string& unit) {
  return channel.unit_under_test.empty() || channel.unit_under_test == unit;
}

bool are_same_number(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Adds equipment unless it is listed already. Equipment that was recalibrated between two records is listed once per
/// calibration.
void add_once(std::vector<report::Equipment>& all, report::Equipment one) {
  const auto same = [&](const report::Equipment& other) {
    return other.role == one.role && other.channel == one.channel && other.name == one.name &&
           other.certificate == one.certificate && other.certificate_sha256 == one.certificate_sha256 &&
           other.calibrated == one.calibrated && other.due == one.due &&
           are_same_number(other.standard_uncertainty_k, one.standard_uncertainty_k) &&
           are_same_number(other.drift_k_in_a_year, one.drift_k_in_a_year);
  };
  const auto known = std::ranges::find_if(all, same);
  if (known == all.end()) return all.push_back(std::move(one));
  known->overdue = known->overdue || one.overdue;
}

report::Equipment thermometer(const record::Channel& channel, Duration end) {
  const auto kelvins = [](const std::optional<Kelvins>& value) {
    return value ? value->value : std::numeric_limits<double>::quiet_NaN();
  };
  return {.role = "thermometer",
          .channel = channel.name,
          .name = channel.instrument,
          .certificate = channel.certificate,
          .certificate_sha256 = channel.certificate_file ? channel.certificate_file->sha256 : "",
          .calibrated = format_day_if_any(channel.uncertainty.calibrated),
          .due = format_day_if_any(channel.due),
          .standard_uncertainty_k = kelvins(channel.uncertainty.calibration),
          .drift_k_in_a_year = kelvins(channel.uncertainty.drift_in_a_year),
          .overdue = channel.due && format_day_if_any(channel.due) < utc_day(end)};
}

void add_equipment(report::CalibrationReport& report, const record::RunInfo& info, const record::UnitInfo& unit,
                   Duration end) {
  for (const record::Channel& channel : info.thermometers)
    if (belongs_to(channel, unit.name)) add_once(report.equipment, thermometer(channel, end));
  if (!info.chamber_instrument.empty())
    add_once(report.equipment, {.role = "chamber", .name = info.chamber_instrument});
  if (!unit.instrument.empty()) add_once(report.equipment, {.role = "gyro_readout", .name = unit.instrument});
  for (const record::ValueInfo& value : unit.values)
    if (!value.instrument.empty())
      add_once(report.equipment, {.role = "analogue_input", .channel = value.name, .name = value.instrument});
}

void add_item(report::CalibratedItem& item, const record::UnitInfo& unit) {
  item.name = unit.name;
  if (item.serial_number.empty()) item.serial_number = unit.serial_number;
  if (item.model.empty()) item.model = unit.model;
  if (!item.axes.empty()) return;
  for (std::size_t axis = 0; axis < unit.axes.size(); ++axis) item.axes.push_back(record::axis_label(unit, axis));
}

/// Extends the span of the air temperature to include that of a record, except where the chamber was away from the
/// profile.
void add_air(report::CalibrationReport& report, const record::Record& record) {
  const auto away = record::find_rows_away(record);
  std::optional<std::pair<double, double>> span;
  for (std::size_t i = 0; i < record.chamber_air_c.size(); ++i) {
    const double air = record.chamber_air_c[i];
    if (away[i] || !std::isfinite(air)) continue;
    if (!span) span = {air, air};
    span = {std::min(span->first, air), std::max(span->second, air)};
  }
  if (!span) return;
  const auto known = std::ranges::find(report.influences, "air_temperature", &report::Influence::key);
  if (known == report.influences.end()) {
    report.influences.push_back({.key = "air_temperature", .unit = "°C", .low = span->first, .high = span->second});
  } else {
    known->low = std::min(known->low, span->first);
    known->high = std::max(known->high, span->second);
  }
}

/// Returns the report's kind of deviation for an event, or an empty string if the event is not a deviation.
std::string deviation_kind(const Event& event) {
  constexpr std::string_view kEarlierProfileContinues = "execute: the profile goes on";  // gyrotherm 0.1.0
  constexpr std::array<std::pair<std::string_view, const char*>, 7> kStates{{{"held", "held"},
                                                                             {"suspended", "paused"},
                                                                             {"aborting", "stopped"},
                                                                             {"aborted", "stopped"},
                                                                             {"stopped", "stopped"},
                                                                             {run::kProfileContinues, "resumed"},
                                                                             {kEarlierProfileContinues, "resumed"}}};
  switch (event.kind) {
    case EventKind::interlock: return "interlock";
    case EventKind::note: return "note";
    case EventKind::resumed: return "resumed";
    case EventKind::interrupted: return "stopped";
    case EventKind::dropped: return "dropped";
    case EventKind::returned: return "returned";
    case EventKind::state:
      for (const auto& [begins, kind] : kStates)
        if (event.text.starts_with(begins)) return kind;
      return {};
    case EventKind::started:
    case EventKind::segment:
    case EventKind::fault:
    case EventKind::recovered:
    case EventKind::finished:
    case EventKind::command:
    case EventKind::acknowledged:
    case EventKind::told: return {};
  }
  return {};
}

/// Returns whether an event belongs to another unit.
bool belongs_to_other_unit(const Event& event, const record::RunInfo& info, const std::string& unit) {
  const std::string& channel = event.about.channel;
  if (channel.empty()) return false;
  const auto thermometer = std::ranges::find(info.thermometers, channel, &record::Channel::name);
  if (thermometer != info.thermometers.end()) return !belongs_to(*thermometer, unit);
  const std::string owner = channel.substr(0, channel.find('.'));
  return owner != unit && record::find_unit(info, owner) != nullptr;
}

std::string format_utc(Duration utc) { return utc > Duration{} ? civil_time(utc) : std::string(); }

void add_gaps(std::vector<report::Deviation>& deviations, const record::Record& record) {
  for (const record::Gap& gap : record.gaps) {
    const Duration begins = record.info.started_utc + std::chrono::seconds(gap.first);
    deviations.push_back({.utc = record.info.imported ? "" : format_utc(begins),
                          .run = record.info.id,
                          .kind = "gap",
                          .text = gap.cause,
                          .seconds = static_cast<double>(gap.last - gap.first + 1)});
  }
}

void add_faults(std::vector<report::Deviation>& deviations, const record::Record& record, const std::string& unit) {
  std::map<std::pair<std::string, std::string>, std::pair<const Event*, int>> by_subject;
  for (const record::RecordedEvent& one : record.events) {
    if (one.event.kind != EventKind::fault || belongs_to_other_unit(one.event, record.info, unit)) continue;
    auto& [first, count] = by_subject[{one.event.about.interlock, one.event.about.channel}];
    if (count++ == 0) first = &one.event;
  }
  for (const auto& [subject, faults] : by_subject) {
    const auto& [first, count] = faults;
    deviations.push_back({.utc = format_utc(first->at.utc),
                          .run = record.info.id,
                          .kind = subject.first.empty() ? "fault" : "alarm",
                          .text = count > 1 ? fmt::format("{} ({} ×)", first->text, count) : first->text});
  }
}

/// Returns whether an event ends the state that the run was in.
bool ends_state(const Event& event) {
  return event.kind == EventKind::state || event.kind == EventKind::resumed || event.kind == EventKind::interrupted ||
         event.kind == EventKind::finished;
}

/// Returns the time from the event at `index` until the next change of state; NaN if it is unknown.
double seconds_in_state(const std::vector<record::RecordedEvent>& events, std::size_t index) {
  const auto begins = events.begin() + static_cast<std::ptrdiff_t>(index);
  const auto next = std::find_if(begins + 1, events.end(), [](const auto& one) { return ends_state(one.event); });
  const Duration from = begins->event.at.utc;
  if (next == events.end() || !(from > Duration{}) || next->event.at.utc < from)
    return std::numeric_limits<double>::quiet_NaN();
  return std::chrono::duration<double>(next->event.at.utc - from).count();
}

/// Removes the state from the text of a stop: "aborting: aborted by ada" becomes "aborted by ada".
std::string remove_stop_state(std::string text) {
  constexpr std::array<std::string_view, 3> kStates{"aborting: ", "aborted: ", "stopped: "};
  for (const std::string_view state : kStates)
    if (text.starts_with(state)) return text.substr(state.size());
  return text;
}

/// Adds an event to the row of a stop, with the time since the stop began, and returns true. Returns false if the event
/// has another cause. The event that ends a stop appends the state of the chamber to the cause.
bool extend_stop(report::Deviation& stop, Duration begun, const Event& event) {
  const bool is_end_note = event.kind == EventKind::interlock && event.about.interlock.empty();
  if (!is_end_note && deviation_kind(event) != "stopped") return false;
  std::string text = remove_stop_state(event.text);
  const bool is_longer = text.starts_with(stop.text + "; ");
  if (text != stop.text && !is_longer && !stop.text.starts_with(text + "; ")) return false;
  if (is_longer) stop.text = std::move(text);
  if (begun > Duration{} && event.at.utc > begun)
    stop.seconds = std::chrono::duration<double>(event.at.utc - begun).count();
  return true;
}

void add_deviations(std::vector<report::Deviation>& deviations, const record::Record& record, const std::string& unit) {
  std::vector<report::Deviation> own;
  add_gaps(own, record);
  add_faults(own, record, unit);
  std::optional<std::size_t> stop;  // row of the stop in progress
  Duration stop_begun{};
  for (std::size_t i = 0; i < record.events.size(); ++i) {
    const Event& event = record.events[i].event;
    if (stop && extend_stop(own[*stop], stop_begun, event)) continue;
    if (ends_state(event)) stop.reset();
    const std::string kind = deviation_kind(event);
    if (kind.empty() || belongs_to_other_unit(event, record.info, unit)) continue;
    own.push_back({.utc = format_utc(event.at.utc), .run = record.info.id, .kind = kind, .text = event.text});
    if (kind == "stopped") {
      own.back().text = remove_stop_state(event.text);
      stop = own.size() - 1;
      stop_begun = event.at.utc;
    }
    if (kind == "held" || kind == "paused") own.back().seconds = seconds_in_state(record.events, i);
  }
  std::ranges::stable_sort(own, {}, &report::Deviation::utc);
  deviations.insert(deviations.end(), own.begin(), own.end());
}

/// Adds the certificate files of the thermometers of a unit, each once.
void add_certificate_files(report::CalibrationReport& report, const record::RunInfo& info, const std::string& unit) {
  for (const record::Channel& channel : info.thermometers) {
    const auto& file = channel.certificate_file;
    if (!file || !belongs_to(channel, unit)) continue;
    const auto is_it = [&](const report::UsedFile& one) {
      return one.sha256 == file->sha256 && one.name == file->name;
    };
    if (std::ranges::none_of(report.files, is_it))
      report.files.push_back({.role = "certificate_file", .name = file->name, .sha256 = file->sha256});
  }
}

void add_files(report::CalibrationReport& report, const SourceRecord& source) {
  const record::RunInfo& info = source.record.info;
  const auto stopped_in = data::find_stopped_segment(source.record);
  report.files.push_back({.role = "record",
                          .name = source.name,
                          .id = info.id,
                          .sha256 = source.sha256,
                          .program_version = info.program_version,
                          .profile = info.profile_name,
                          .started_utc = format_utc(info.started_utc),
                          .chain_verified = source.chain_verified,
                          .stopped_in_segment = stopped_in ? *stopped_in + 1 : 0,
                          .segments = stopped_in ? static_cast<int>(info.segments.size()) : 0});
  report.files.insert(report.files.end(), source.parts.begin(), source.parts.end());
  const auto add_text = [&](const char* role, const std::string& name, const std::string& text) {
    const std::string digest = sha256(text);
    if (text.empty() || std::ranges::find(report.files, digest, &report::UsedFile::sha256) != report.files.end())
      return;
    report.files.push_back({.role = role, .name = name, .sha256 = digest});
  };
  add_text("profile", info.profile_name, info.profile_text);
  add_text(info.imported ? "column_map" : "rig", info.rig_name, info.rig_text);
}

}  // namespace

void add_record(report::CalibrationReport& report, const SourceRecord& source, const std::string& unit) {
  const record::Record& record = source.record;
  const record::UnitInfo* found = record::find_unit(record.info, unit);
  if (found == nullptr) return;
  report.simulated = report.simulated || record::is_simulated(record.info);
  const Duration end = record.last_utc.value_or(record.info.started_utc);
  if (record.info.started_utc > Duration{}) {
    const std::string begun = utc_day(record.info.started_utc), ended = utc_day(end);
    if (report.begun.empty() || begun < report.begun) report.begun = begun;
    report.ended = std::max(report.ended, ended);
  }
  add_item(report.item, *found);
  add_equipment(report, record.info, *found, end);
  add_air(report, record);
  add_deviations(report.deviations, record, unit);
  add_files(report, source);
  add_certificate_files(report, record.info, unit);
}

}  // namespace gyrotherm::app
