// SPDX-License-Identifier: Apache-2.0
/// The command `standard`: check runs of the golden gyro of a rig on control charts.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "apps/console/command.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/standard/check_page.hpp"
#include "apps/gyrotherm/standard/check_record.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "report/standard/check_chart.hpp"

namespace gyrotherm::app {
namespace {

struct StandardArguments {
  std::string rig, chart, language = "en";
  std::vector<std::string> records;
  bool force = false, unverified = false;
};

Result<void> write_chart(Console& console, const StandardArguments& options, const standard::CheckedStandard& checked) {
  if (options.chart.empty()) return {};
  const auto language = options.language == "de" ? report::Language::german : report::Language::english;
  const bool is_page = options.chart.ends_with(".html");
  if (auto written = replace_text_file(options.chart,
                                       is_page ? to_html(checked, language) : to_svg(checked, {.language = language}));
      !written)
    return written;
  console.print_message(fmt::format("{} written", options.chart));
  return {};
}

Result<Exit> add_check_runs(Console& console, const StandardArguments& options) {
  if (options.rig.empty()) return failure(FaultKind::usage, "rig", "name the rig");
  if (!options.chart.empty()) {
    if (!options.chart.ends_with(".svg") && !options.chart.ends_with(".html"))
      return failure(FaultKind::usage, "--chart", "expected a file that ends in .svg or .html");
    if (auto free = check_is_free(options.chart, options.force); !free) return failure(free.error());
  }
  auto standard = open_standard(options.rig, options.records.empty() ? HistoryAccess::read : HistoryAccess::change);
  if (!standard) return failure(standard.error());
  const std::string before = standard->text;
  if (auto appended = append_records(console, *standard, options.records, options.unverified); !appended)
    return failure(appended.error());
  if (standard->text.empty())
    return failure(FaultKind::usage, standard->path, "there is no check run yet; name the record of one");
  const auto checked = standard::assess_standard(standard->text, standard->path);
  if (!checked) return failure(checked.error());
  if (standard->text != before)
    if (auto written = replace_text_file(standard->path, standard->text); !written) return failure(written.error());
  console.print_report(console.json ? to_json(*checked) : describe(*checked));
  if (auto written = write_chart(console, options, *checked); !written) return failure(written.error());
  return checked->assessment.is_open() ? Exit::outside_limits : Exit::done;
}

struct ExplainArguments {
  std::string rig;
  assurance::Explanation explanation;
};

Result<Exit> explain(Console& console, const ExplainArguments& options) {
  auto standard = open_standard(options.rig, HistoryAccess::change);
  if (!standard) return failure(standard.error());
  if (standard->text.empty()) return failure(FaultKind::usage, standard->path, "there is no check run yet");
  const auto checked = standard::assess_standard(standard->text, standard->path);
  if (!checked) return failure(checked.error());
  assurance::Explanation explanation = options.explanation;
  if (explanation.by.find_first_not_of(" \t") == std::string::npos)
    return failure(FaultKind::usage, "--by", "name the person who explains the check runs");
  for (std::size_t r = 0; r < checked->assessment.runs.size(); ++r)
    if (checked->assessment.runs[r].is_open()) explanation.run_ids.push_back(checked->history.checks[r].run_id);
  if (explanation.run_ids.empty())
    return failure(FaultKind::usage, standard->path, "every check run is in control or explained");
  explanation.utc = civil_time(SteadyClock().now().utc);
  standard->text = append(std::move(standard->text), explanation);
  const auto explained = standard::assess_standard(standard->text, standard->path);
  if (!explained) return failure(explained.error());
  if (auto written = replace_text_file(standard->path, standard->text); !written) return failure(written.error());
  console.print_report(console.json ? to_json(*explained) : describe(*explained));
  return explained->assessment.is_open() ? Exit::outside_limits : Exit::done;
}

void add_explain(Program& program, CLI::App& standard) {
  auto [command, options] = add_subcommand(
      program, standard, "explain", "Explains all check runs that are out of control, so that reports can be issued.",
      "gyrotherm standard explain lab.toml --cause thermometer --part B --by \"A. Metrologist\"", explain);
  command.add_option("rig", options.rig, "the rig")->type_name(value::kRig)->required();
  command.add_option("--cause", options.explanation.cause, "thermometer, mount, gyro, false_alarm or other")
      ->check(CLI::IsMember({"thermometer", "mount", "gyro", "false_alarm", "other"}))
      ->required();
  command.add_option("--by", options.explanation.by, "the person who explains")->type_name("NAME")->required();
  command.add_option("--part", options.explanation.part, "the part, such as the thermometer")->type_name("NAME");
  command.add_option("--note", options.explanation.note, "what was found and done")->type_name("TEXT");
  command.add_flag("--new-level", options.explanation.new_level,
                   "the change remains: compare later runs with each other, not with the earlier ones");
}

}  // namespace

void add_standard(Program& program) {
  auto [command, options] = add_command(
      program, "standard",
      "Puts check runs of the golden gyro of a rig on control charts and names the probable cause of a change.",
      "gyrotherm standard lab.toml check-2026-11-25.db --chart charts.html", add_check_runs);
  command.add_option("rig", options.rig, "the rig, with [check_standard]")->type_name(value::kRig);
  command.add_option("records", options.records, "records of check runs to add to the history")
      ->type_name(value::kRecord);
  command.add_option("--chart", options.chart, "also write the control charts: a figure .svg or a page .html")
      ->check(reject_dash())
      ->type_name(value::kFile);
  command.add_option("--language", options.language, "language of the charts, en or de (default: en)")
      ->check(CLI::IsMember({"en", "de"}));
  add_force_flag(command, options.force);
  add_unverified_flag(command, options.unverified);
  add_explain(program, command);
}

}  // namespace gyrotherm::app
