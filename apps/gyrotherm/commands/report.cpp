// SPDX-License-Identifier: Apache-2.0
/// `gyrotherm report` and `report compare`.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/record/record_files.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/report/calibration.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "core/file.hpp"
#include "core/text.hpp"
#include "report/comparison.hpp"
#include "report/signed_report.hpp"
#include "report/views.hpp"

namespace gyrotherm::app {

// Further subcommands, defined in report_state.cpp and report_verify.cpp.
void add_report_state(Program& program, CLI::App& report);
void add_report_sign(Program& program, CLI::App& report);
void add_report_verify(Program& program, CLI::App& report);

namespace {

/// Rebuilds the report of the experiment in a folder that qualify wrote.
Result<Exit> rebuild(Console& console, const std::string& folder) {
  const auto report = folder + "/report";
  if (!record::path_exists(report)) {
    const bool is_calibration = record::path_exists(folder + "/" + report::kCalibrationFile);
    return failure(FaultKind::bad_file, folder,
                   is_calibration ? "contains a calibration report; name a command, such as report verify"
                                  : "has no folder \"report\", expected a folder that qualify wrote");
  }
  if (auto rebuilt = report::rebuild_report(report); !rebuilt) return failure(rebuilt.error());
  console.print_message(report + "/report.html");
  return Exit::done;
}

/// Returns whether models are read from a folder: a named one, or the folder of the records.
bool has_model_folder(const CalibrationArguments& options, bool is_folder) {
  const bool are_there_too = is_folder && !options.out.empty() && options.left.empty();
  return are_there_too || !options.left_folder.empty() || !options.found_folder.empty();
}

/// Fails with usage if a language is named twice.
Result<void> check_languages(const std::vector<std::string>& languages) {
  for (const auto& language : languages)
    if (std::ranges::count(languages, language) > 1)
      return failure(FaultKind::usage, "--language", fmt::format("{} is given twice", language));
  return {};
}

/// Fails unless the first argument is a record or a folder.
Result<void> check_subject(const std::string& subject) {
  if (record::path_exists(subject) || record::find_record_files(subject)) return {};
  return failure(FaultKind::bad_file, subject, "no such record or folder");
}

Result<Exit> report_on(Console& console, const CalibrationArguments& options) {
  if (options.runs.empty()) return failure(FaultKind::usage, "records", "name records, or a folder that qualify wrote");
  if (auto valid = check_languages(options.languages); !valid) return failure(valid.error());
  if (auto there = check_subject(options.runs.front()); !there && options.out.empty()) return failure(there.error());
  const bool is_folder = options.runs.size() == 1 && std::filesystem::is_directory(options.runs.front());
  if (!options.inputs.empty() && !has_model_folder(options, is_folder))
    return failure(FaultKind::usage, "--inputs",
                   "selects models in a folder; name the folder with --models or --found-models");
  if (is_folder && options.out.empty()) return rebuild(console, options.runs.front());
  if (options.out.empty()) return failure(FaultKind::usage, "--out", "name the folder that the report is written to");
  if (!is_folder) return calibrate(console, options);
  CalibrationArguments folder_options = options;
  const std::string folder = options.runs.front();
  folder_options.runs = {record::ramp_record_path(folder), folder + "/random.db"};
  if (folder_options.left.empty() && folder_options.left_folder.empty()) folder_options.left_folder = folder;
  return calibrate(console, folder_options);
}

struct CompareArguments {
  std::string before, now, out, check_standard;
  std::vector<std::string> languages{"en"};
};

Result<Exit> compare_reports(Console& console, const CompareArguments& options) {
  const auto before = load_calibration(options.before), now = load_calibration(options.now);
  if (!before || !now) return failure(before ? now.error() : before.error());
  if (auto valid = check_languages(options.languages); !valid) return failure(valid.error());
  if (before->sha256 == now->sha256)
    return failure(FaultKind::usage, now->path, fmt::format("is the same report as {}", before->path));
  if (!options.out.empty() && record::path_exists(options.out + "/" + report::kCalibrationFile))
    return failure(FaultKind::usage, options.out, "contains a report; name another folder for the comparison");
  for (const FiledReport* one : {&*before, &*now})
    if (auto same = check_is_unchanged(console, *one, WithoutDigest::accepted); !same) return failure(same.error());
  const auto comparison = report::compare_files(*before, *now, options.check_standard);
  if (!comparison) return failure(comparison.error());
  console.print_report(console.json ? to_json(*comparison) : describe(*comparison));
  if (options.out.empty()) return Exit::done;
  const ComparedFiles files{.before = before->path, .now = now->path, .history = options.check_standard};
  return write_comparison(console, *comparison, files, options.out, options.languages).map([] { return Exit::done; });
}

void add_languages(CLI::App& command, std::vector<std::string>& languages) {
  command.add_option("--language", languages, "en, de, or both: en,de (default: en)")
      ->delimiter(',')
      ->check(CLI::IsMember({"en", "de"}));
}

void add_report_compare(Program& program, CLI::App& report) {
  auto [command, options] = add_subcommand(
      program, report, "compare", "Compares two calibrations of a unit; prints each change with its U and E_n.",
      "gyrotherm report compare 2025/calibration 2026/calibration", compare_reports);
  command.add_option("before", options.before, "the folder of the earlier report, or its calibration.json")
      ->type_name(value::kFolder)
      ->required();
  command.add_option("now", options.now, "the folder of the later report, or its calibration.json")
      ->type_name(value::kFolder)
      ->required();
  command.add_option("--out", options.out, "also write comparison.json, its page and its PDF into this folder")
      ->check(reject_dash())
      ->type_name(value::kFolder);
  command
      .add_option("--check-standard", options.check_standard,
                  "history of check runs of the rig: also states whether it was in control at each record")
      ->type_name(value::kFile);
  add_languages(command, options.languages);
}

}  // namespace

void add_report(Program& program) {
  auto [command, options] = add_command(
      program, "report",
      "Writes the calibration report of a unit from its records. For a folder that qualify wrote, without --out, "
      "rebuilds the report of the experiment.",
      "gyrotherm report out --order order.toml --laboratory laboratory.toml --out out/calibration", report_on);
  command.add_option("records", options.runs, "the records, or the folder that qualify wrote")
      ->type_name(value::kRecordOrFolder);
  command.add_option("--out", options.out, "the folder of the report")->check(reject_dash())->type_name(value::kFolder);
  command.add_option("--model", options.left, "the as-left model; may be repeated, one per axis")
      ->type_name(value::kModel);
  command.add_option("--models", options.left_folder, "the as-left models of all axes, in a folder that qualify wrote")
      ->type_name(value::kFolder);
  command.add_option("--found", options.found, "the as-found model; may be repeated, one per axis")
      ->type_name(value::kModel);
  command
      .add_option("--found-models", options.found_folder,
                  "the as-found models of all axes, in a folder that qualify wrote")
      ->type_name(value::kFolder);
  command.add_option("--inputs", options.inputs, "NAME of the models in these folders (default: multi-point-t)")
      ->type_name("NAME");
  command.add_option("--unit", options.unit, "the unit to report on, for records with several units under test")
      ->type_name("UNIT");
  add_report_texts(command, options);
  command
      .add_option("--check-standard", options.check_standard,
                  "history of check runs (default: that of a real rig, if its rig file names one); the report stays a "
                  "draft if a run is out of control and not explained")
      ->type_name(value::kFile);
  add_languages(command, options.languages);
  add_unverified_flag(command, options.unverified);
  add_report_state(program, command);
  add_report_compare(program, command);
  add_report_sign(program, command);
  add_report_verify(program, command);
}

}  // namespace gyrotherm::app
