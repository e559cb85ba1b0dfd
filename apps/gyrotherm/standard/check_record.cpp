// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/standard/check_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/check_history.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "analysis/assurance/record_state.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/standard/history_lock.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::size_t kMostRecordBytes = 4'000'000'000;

/// A verified record of a check run.
struct CheckRecord {
  record::RecordFiles files;
  record::RunInfo info;
  std::string sha256;
};

Result<CheckRecord> open_record(Console& console, const std::string& path, bool unverified) {
  auto checked = check_recorded_run(console, path, unverified);
  if (!checked) return failure(checked.error());
  auto info = record::read_info(checked->files);
  if (!info) return failure(info.error());
  auto digest = checked->verified.manifest ? checked->verified.digest : record::file_digest(path, kMostRecordBytes);
  if (!digest) return failure(digest.error());
  return CheckRecord{std::move(checked->files), std::move(*info), std::move(*digest)};
}

bool is_golden(const rig::CheckStandard& standard, const record::UnitInfo& unit) {
  return std::ranges::count(standard.serial_numbers, unit.serial_number) > 0;
}

/// Loads all axes of the golden units. Fails with usage if one of the units is not in the record.
Result<std::vector<data::Dataset>> load_golden_axes(const CheckRecord& record, const rig::CheckStandard& standard) {
  for (const std::string& serial : standard.serial_numbers)
    if (std::ranges::count(record.info.units, serial, &record::UnitInfo::serial_number) == 0)
      return failure(FaultKind::usage, record.files.path,
                     fmt::format("has no unit with the serial number {} of the golden gyro", serial));
  std::vector<data::Dataset> axes;
  for (const record::UnitInfo& unit : record.info.units) {
    if (!is_golden(standard, unit)) continue;
    for (const record::AxisInfo& axis : unit.axes) {
      auto dataset = data::load_dataset(record.files, data::AxisChoice{unit.name, axis.name});
      if (!dataset) return failure(dataset.error());
      axes.push_back(std::move(*dataset));
    }
  }
  return axes;
}

assurance::CheckedThermometer describe_thermometer(const data::Dataset& run, std::size_t index) {
  const auto& known = run.thermometer_uncertainty[index];
  const auto value = [](const std::optional<Kelvins>& u) { return u ? u->value : 0; };
  return {run.thermometers[index], std::hypot(value(known.calibration), value(known.drift_in_a_year)),
          value(known.drift_in_a_year)};
}

void add_instruments(assurance::CheckEntry& check, const std::vector<data::Dataset>& axes) {
  for (const data::Dataset& run : axes) {
    assurance::CheckedAxis axis{.axis = qualified_name(run.of),
                                .earth_rate_deg_per_h = run.earth_rate_deg_per_h.value_or(0),
                                .turn_on_deg_per_h = run.gyro_uncertainty.turn_on_repeatability_deg_per_h.value_or(0)};
    if (run.direction) axis.direction.assign(run.direction->begin(), run.direction->end());
    check.axes.push_back(std::move(axis));
    for (std::size_t i = 0; i < run.thermometer_uncertainty.size(); ++i) {
      const auto is_same = [&](const auto& one) { return one.name == run.thermometers[i]; };
      if (!data::is_own_value(run.thermometers[i]) && std::ranges::none_of(check.thermometers, is_same))
        check.thermometers.push_back(describe_thermometer(run, i));
    }
  }
}

Result<assurance::CheckEntry> measure(const CheckRecord& record, const rig::CheckStandard& standard) {
  const auto axes = load_golden_axes(record, standard);
  if (!axes) return failure(axes.error());
  auto results = assurance::measure_check_run(*axes);
  if (!results) return failure(results.error());
  assurance::CheckEntry check{.run_id = record.info.id,
                              .started_utc = civil_time(record.info.started_utc),
                              .record = std::filesystem::path(record.files.path).filename().string(),
                              .sha256 = record.sha256,
                              .program_version = GYROTHERM_VERSION,
                              .results = std::move(*results)};
  add_instruments(check, *axes);
  return check;
}

assurance::HistoryHead make_head(const rig::RigFile& rig) {
  const rig::CheckStandard& standard = *rig.check_standard;
  return {.rig = rig.name,
          .simulated = rig.simulated,
          .serial_numbers = standard.serial_numbers,
          .profile = standard.profile,
          .profile_sha256 = "",
          .false_alarm_rate = standard.false_alarm_rate,
          .mount_change_deg = standard.mount_change_deg,
          .gyro_change_deg_per_h = standard.gyro_change_deg_per_h};
}

/// Fails with usage unless the record is a check run that can be compared with the others.
Result<void> check_fits(const CheckRecord& record, const assurance::HistoryHead& head) {
  const auto refuse = [&](const std::string& why) { return failure(FaultKind::usage, record.files.path, why); };
  const record::RunInfo& info = record.info;
  if (info.rig_name != head.rig) return refuse(fmt::format("is of the rig {}, expected {}", info.rig_name, head.rig));
  if (record::is_simulated(info) != head.simulated)
    return refuse("is SIMULATED and the check standard is real, or the reverse");
  if (info.profile_name != head.profile)
    return refuse(fmt::format("is a run of {}, expected the check profile {}", info.profile_name, head.profile));
  if (!head.profile_sha256.empty() && sha256(info.profile_text) != head.profile_sha256)
    return refuse(
        "its profile differs from that of the previous check runs, so the results cannot be compared; begin a new "
        "history");
  return {};
}

/// Appends a check run to the text of the history and verifies the result.
Result<void> append_check(StandardOfRig& standard, const CheckRecord& record) {
  assurance::HistoryHead head = make_head(standard.rig);
  if (standard.text.empty()) {
    head.profile_sha256 = sha256(record.info.profile_text);
    standard.text = start_history(head);
  }
  const auto history = assurance::parse_history(standard.text, standard.path);
  if (!history) return failure(history.error());
  if (auto fits = check_fits(record, history->head); !fits) return fits;
  auto check = measure(record, *standard.rig.check_standard);
  if (!check) return failure(check.error());
  if (!history->checks.empty() && check->started_utc <= history->checks.back().started_utc)
    return failure(FaultKind::usage, record.files.path,
                   fmt::format("started {}, before the last check run of the history, {}; check runs are added in the "
                               "order of their time",
                               check->started_utc, history->checks.back().started_utc));
  standard.text = append(std::move(standard.text), *check);
  return assurance::parse_history(standard.text, standard.path).map([](const auto&) {});
}

}  // namespace

std::string history_path(const std::string& history, const std::string& rig_file) {
  return (std::filesystem::path(parent_folder(rig_file)) / history).lexically_normal().string();
}

std::optional<std::string> find_history(const record::RunInfo& info) {
  if (info.rig_file.empty()) return {};
  auto paths = record::list_check_histories(info, info.rig_file);
  if (paths.empty() || !read_file_state(paths.front()).is_there()) return {};
  return paths.front();
}

Result<StandardOfRig> open_standard(const std::string& given, HistoryAccess access) {
  auto rig = load_rig(given);
  if (!rig) return failure(rig.error());
  if (!rig->check_standard)
    return failure(FaultKind::usage, rig->file,
                   "has no golden gyro; add [check_standard] with its serial_numbers (docs/check-standard.md)");
  StandardOfRig standard{.rig = std::move(*rig)};
  standard.path = history_path(standard.rig.check_standard->history, standard.rig.file);
  if (access == HistoryAccess::change) {
    auto lock = lock_history(standard.path);
    if (!lock) return failure(lock.error());
    standard.lock = std::move(*lock);
  }
  auto text = read_text_file_if_any(standard.path, kLargestTable);
  if (!text) return failure(text.error());
  if (!*text) return standard;
  standard.text = std::move(**text);
  const auto history = assurance::parse_history(standard.text, standard.path);
  if (!history) return failure(history.error());
  auto head = make_head(standard.rig);
  head.profile_sha256 = history->head.profile_sha256;
  if (head != history->head)
    return failure(FaultKind::usage, standard.path,
                   "was begun with other settings of [check_standard], another rig name or another kind of rig; give "
                   "`history` a new name");
  return standard;
}

Result<void> append_records(Console& console, StandardOfRig& standard, const std::vector<std::string>& records,
                            bool unverified) {
  std::vector<CheckRecord> opened;
  for (const std::string& path : records) {
    auto record = open_record(console, path, unverified);
    if (!record) return failure(record.error());
    opened.push_back(std::move(*record));
  }
  std::ranges::stable_sort(opened, {}, [](const CheckRecord& one) { return one.info.started_utc; });
  for (const CheckRecord& record : opened) {
    if (!standard.text.empty()) {
      const auto history = assurance::parse_history(standard.text, standard.path);
      if (!history) return failure(history.error());
      if (std::ranges::count(history->checks, record.info.id, &assurance::CheckEntry::run_id) > 0) {
        console.print_message(fmt::format("{}: is in the history already", record.files.path));
        continue;
      }
    }
    if (auto appended = append_check(standard, record); !appended) return appended;
  }
  return {};
}

std::optional<std::string> describe_open_check(const assurance::History& history,
                                               const std::vector<std::string>& started_utc) {
  const auto assessment = assess(history);
  const auto is_open = [&](const std::string& utc) {
    return find_state(history, assessment, utc).state == assurance::CheckState::out_of_control;
  };
  if (std::ranges::none_of(started_utc, is_open)) return {};
  const auto first = std::ranges::find_if(assessment.runs, &assurance::RunVerdict::is_open) - assessment.runs.begin();
  return fmt::format(
      "check standard of the rig {}: out of control since the check run of {} and not explained (gyrotherm standard "
      "explain)",
      history.head.rig, history.checks[static_cast<std::size_t>(first)].started_utc);
}

}  // namespace gyrotherm::app
