// SPDX-License-Identifier: Apache-2.0
/// The command `fuse`: combines many axes into one rate vector.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "analysis/fusion/voting.hpp"
#include "analysis/model/fused_axes.hpp"
#include "analysis/model/fused_run.hpp"
#include "analysis/model/model_export.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/number_text.hpp"
#include "report/fusion_view.hpp"

namespace gyrotherm::app {
namespace {

struct FuseArguments {
  std::vector<std::string> runs, models, axes;
  std::string folder, inputs = "multi-point-t", healthy, out, report, export_c, outside = "continue";
  model::FusionOptions fusion;
  bool keep_all = false;
  bool force = false, unverified = false;
};

/// Maps the name of an axis, such as "u1.x", to its model file.
using ModelFiles = std::map<std::string, std::string>;

Result<ModelFiles> named_models(const std::vector<std::string>& arguments) {
  ModelFiles files;
  for (const std::string& argument : arguments) {
    const auto at = argument.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == argument.size())
      return failure(FaultKind::usage, "--model",
                     fmt::format("\"{}\", expected AXIS=FILE like u1.x=model.json", argument));
    if (!files.emplace(argument.substr(0, at), argument.substr(at + 1)).second)
      return failure(FaultKind::usage, "--model", fmt::format("{} has two models", argument.substr(0, at)));
  }
  return files;
}

/// Returns the model file of an axis: the one given on the command line, otherwise the path where qualify writes it.
/// Fails with usage if there is neither.
Result<std::string> find_model_file(const FuseArguments& options, const ModelFiles& named,
                                    const data::AxisChoice& axis) {
  const auto name = qualified_name(axis);
  if (const auto found = named.find(name); found != named.end()) return found->second;
  if (options.folder.empty())
    return failure(
        FaultKind::usage, "--model",
        fmt::format("the axis {0} has no model; add --model {0}=FILE, or name a folder with --models", name));
  return model_path(options.folder, axis, options.inputs);
}

/// Returns the requested axes, or all if none was requested.
Result<std::vector<data::AxisChoice>> axes_to_fuse(const record::RunInfo& info,
                                                   const std::vector<std::string>& requested, const std::string& path) {
  const std::vector<data::AxisChoice> all = data::list_axes(info);
  if (requested.empty()) return all;
  std::vector<data::AxisChoice> chosen;
  for (const std::string& name : requested) {
    const auto at = std::ranges::find(all, name, data::qualified_name);
    if (at == all.end()) {
      std::vector<std::string> names;
      std::ranges::transform(all, std::back_inserter(names), data::qualified_name);
      return failure(FaultKind::usage, path,
                     fmt::format("has no axis \"{}\"; its axes are {}", name, fmt::join(names, ", ")));
    }
    if (std::ranges::find(chosen, *at) != chosen.end())
      return failure(FaultKind::usage, "--axes", fmt::format("\"{}\" is given twice", name));
    chosen.push_back(*at);
  }
  return chosen;
}

Result<void> check_models_used(const ModelFiles& named, const std::vector<data::AxisChoice>& axes,
                               const std::string& path) {
  std::vector<std::string> names;
  std::ranges::transform(axes, std::back_inserter(names), data::qualified_name);
  for (const auto& [name, file] : named)
    if (std::ranges::find(axes, name, data::qualified_name) == axes.end())
      return failure(
          FaultKind::usage, "--model",
          fmt::format("\"{}\" is not one of the axes of {} to fuse: {}", name, path, fmt::join(names, ", ")));
  return {};
}

Result<model::FusedAxes> load_axes(Console& console, const std::string& path, const FuseArguments& options) {
  const auto outside = model::parse_outside(options.outside);
  if (!outside) return failure(outside.error());
  const auto named = named_models(options.models);
  if (!named) return failure(named.error());
  const auto checked = check_recorded_run(console, path, options.unverified);
  if (!checked) return failure(checked.error());
  const auto record = record::read_record(checked->files);
  if (!record) return failure(record.error());
  if (!record->finished)
    return failure(FaultKind::usage, path, "the run has not finished; \"gyrotherm resume\" completes it");
  const auto chosen = axes_to_fuse(record->info, options.axes, path);
  if (!chosen) return failure(chosen.error());
  if (auto models_used = check_models_used(*named, *chosen, path); !models_used) return failure(models_used.error());
  std::vector<model::CompensatedAxis> axes;
  for (const data::AxisChoice& axis : *chosen) {
    const auto file = find_model_file(options, *named, axis);
    if (!file) return failure(file.error());
    auto model = load_model(*file);
    if (!model) return failure(model.error());
    axes.push_back({data::make_dataset(*record, path, axis), std::move(*model)});
  }
  return compensate_axes(axes, *outside);
}

/// Values learnt from a record without faults.
struct HealthyReference {
  std::optional<fusion::ThermometerParity> thermometers{};
  std::optional<model::HealthyRates> rates{};
  /// Message on what is missing; printed with the first fused record.
  std::string remark{};
};

/// Learns from the record of --healthy or, without that option, from the ramp run that qualify wrote next to the
/// models. Learns rates only from the record of --healthy, because the errors of a model are smaller on the record on
/// which it was trained.
Result<HealthyReference> learn_healthy(Console& console, const FuseArguments& options) {
  std::string path = options.healthy;
  if (path.empty()) {
    path = record::ramp_record_path(options.folder);
    if (options.folder.empty() || !std::filesystem::exists(path)) {
      return HealthyReference{
          .remark =
              "no fault-free record is known, so the thermometers are not compared with each other; use "
              "--healthy RECORD"};
    }
  }
  const auto healthy = load_axes(console, path, options);
  if (!healthy) return failure(healthy.error());
  auto learnt = healthy_thermometers(*healthy, options.fusion.cluster_s);
  if (!learnt && options.healthy.empty()) {
    return HealthyReference{
        .remark = fmt::format("the thermometers are not compared with each other: {}", text(learnt.error()))};
  }
  if (!learnt) return failure(learnt.error());
  HealthyReference all{.thermometers = std::move(*learnt)};
  if (!options.healthy.empty()) all.rates = healthy_rates(*healthy, options.fusion.cluster_s);
  return all;
}

std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string();
}

constexpr const char* kCsvHeader =
    "time_s,rate_x_deg_per_h,rate_y_deg_per_h,rate_z_deg_per_h,U_x_deg_per_h,U_y_deg_per_h,U_z_deg_per_h,parity,"
    "contradicts,left_out\n";

/// Returns a line of the table; missing values are empty fields.
std::string csv_line(const model::FusedAxes& axes, const model::FusedRun& run, Eigen::Index row) {
  std::string line = number(run.time_s(row), 0);
  for (Eigen::Index k = 0; k < 3; ++k) line += "," + number(run.rate_deg_per_h(row, k), 6);
  for (Eigen::Index k = 0; k < 3; ++k) line += "," + number(run.expanded_deg_per_h(row, k), 6);
  const auto at = static_cast<std::size_t>(row);
  const model::AxisSet all = ~model::AxisSet{0} >> static_cast<unsigned>(64 - axes.axes());
  return line + fmt::format(",{},{},{}\n", number(run.statistic(row), 4), run.contradicts[at] ? 1 : 0,
                            names_in(axes, all & ~run.used[at]));
}

Result<void> write_csv(Console& console, const model::FusedAxes& axes, const model::FusedRun& run,
                       const std::string& path) {
  std::string text = axes.simulated ? "# SIMULATED\n" : "";
  text += kCsvHeader;
  constexpr std::size_t kPiece = 1 << 20;
  for (Eigen::Index row = 0; row < run.time_s.size(); ++row) {
    text += csv_line(axes, run, row);
    if (path != "-" || text.size() < kPiece) continue;
    console.print(text);
    text.clear();
  }
  if (path != "-") return replace_text_file(path, text);
  console.print(text);
  return {};
}

std::string vector_line(const char* what, const std::vector<double>& values) {
  return fmt::format("  {:<34} {:>10.5f} {:>10.5f} {:>10.5f}\n", what, values[0], values[1], values[2]);
}

std::string describe(const char* what, const std::optional<model::RateError>& error) {
  if (!error) return "";
  return fmt::format("  {:<34} RMS {:.5f} °/h: mean {:.5f}, about the mean {:.5f} ({} means)\n", what,
                     error->rms_deg_per_h, error->mean_deg_per_h, error->about_mean_deg_per_h, error->clusters);
}

std::string describe_rest(const model::FusionSummary& summary) {
  if (!summary.rest) return "";
  const model::RestStretch& rest = *summary.rest;
  std::string text = fmt::format("at rest, mean over the last hour of {} holds:\n", summary.holds.size()) +
                     vector_line("rate, °/h", rest.rate.deg_per_h) +
                     vector_line("U (k = 2), °/h", rest.rate.expanded_deg_per_h) +
                     vector_line("rate minus Earth rate, °/h", rest.residual_deg_per_h);
  text += rest.heading_deg
              ? fmt::format("  {:<34} ({})° (95 %); the record states {:.4f}°\n", "heading of x",
                            format_with_error(*rest.heading_deg, *rest.heading_expanded_deg), *summary.said_heading_deg)
              : fmt::format("  {:<34} not found: {}\n", "heading of x", rest.no_heading);
  if (rest.turn_deg.empty()) return text;
  text += fmt::format("  {:<34} {:.1f} of {}, limit {:.1f}\n", "χ² of readings and priors", rest.statistic,
                      rest.bias_deg_per_h.size(), rest.limit);
  for (std::size_t k = 0; k < 3; ++k) {
    constexpr const char* kTurns[] = {"turn about north", "turn about east", "turn about down"};
    text +=
        fmt::format("  {:<34} ({})° (k = 1)\n", kTurns[k], format_with_error(rest.turn_deg[k], rest.turn_std_deg[k]));
  }
  for (std::size_t a = 0; a < rest.axes.size(); ++a)
    text += fmt::format("  {:<34} {} °/h (k = 1)\n", "bias of " + rest.axes[a],
                        format_with_error(rest.bias_deg_per_h[a], rest.bias_std_deg_per_h[a]));
  return text;
}

std::string describe(const model::FusionSummary& summary, const std::string& path) {
  std::string text = fmt::format("{}{}: {} axes, {} of {} seconds fused\n", summary.simulated ? "SIMULATED " : "", path,
                                 summary.axes.size(), summary.fused, summary.seconds);
  for (const model::FusedAxisSummary& axis : summary.axes)
    text += fmt::format("  {:<12} {} {}: u {:.5f} °/h in 1 s, {:.5f} in 1 h; RMS error {:.5f}; excluded for {} s\n",
                        axis.name, axis.method, axis.inputs, axis.second_std_deg_per_h, axis.hour_std_deg_per_h,
                        axis.error_rms_deg_per_h, axis.left_out_s);
  text += std::isfinite(summary.limit)
              ? fmt::format("parity: {} seconds above the limit {:.1f} (false-alarm probability {:g} per second)\n",
                            summary.contradictions, summary.limit, summary.false_alarm_probability)
              : "parity: not available with three axes\n";
  if (summary.error) {
    text += "error relative to the Earth rate, magnitude of the vector:\n" + describe("fused", summary.error) +
            describe("all axes, none excluded", summary.of_all_axes) + describe("first three axes", summary.of_three);
    if (summary.within_expanded)
      text += fmt::format("  {:<34} {:.1f} %\n", "components within their U (k = 2)", 100 * *summary.within_expanded);
  }
  text += describe_rest(summary);
  for (const std::string& warning : summary.warnings) text += "warning: " + warning + "\n";
  if (summary.alarms.empty()) return text + "no alarms\n";
  constexpr std::size_t kMaxListedAlarms = 20;
  for (std::size_t i = 0; i < std::min(kMaxListedAlarms, summary.alarms.size()); ++i) {
    const model::Alarm& alarm = summary.alarms[i];
    text += fmt::format("{:.0f} s: {}{}: {}\n", alarm.at_s, name(alarm.kind),
                        alarm.who.empty() ? "" : " of " + alarm.who, alarm.statement);
  }
  if (summary.alarms.size() > kMaxListedAlarms)
    text += fmt::format("… and {} more\n", summary.alarms.size() - kMaxListedAlarms);
  return text;
}

/// Returns the path of the header that is written next to a C source.
std::filesystem::path header_path(const std::filesystem::path& source) {
  auto header = source;
  header.replace_filename(model::c_name(source.stem().string()) + ".h");
  return header;
}

/// Fails with usage if an output has a wrong name or exists.
Result<void> check_outputs(const FuseArguments& options) {
  for (const std::string& file : {options.out, options.export_c})
    if (!file.empty() && file != "-")
      if (auto free = check_is_free(file, options.force); !free) return free;
  if (!options.export_c.empty()) {
    if (std::filesystem::path(options.export_c).extension() != ".c")
      return failure(FaultKind::usage, "--export-c",
                     "the name of a C source must end in .c; its header is written next to it");
    if (auto free = check_is_free(header_path(options.export_c).string(), options.force); !free) return free;
  }
  std::error_code error;
  if (!options.report.empty() && std::filesystem::is_directory(options.report, error))
    for (const char* file : {"fusion.html", "fusion.json"})
      if (auto free = check_is_free(options.report + "/" + file, options.force); !free) return free;
  return {};
}

/// Writes the C source and, next to it, its header.
Result<void> write_c(Console& console, const model::FusedRun& run, const FuseArguments& options) {
  const std::filesystem::path source = options.export_c, header = header_path(source);
  const std::string name = model::c_name(source.stem().string());
  const auto program = model::fusion_to_c(
      run.geometry, name,
      {.false_alarm_probability = options.fusion.watch.false_alarm_probability, .margin = options.fusion.watch.margin},
      run.weights);
  if (!program) return failure(program.error());
  if (auto written = replace_text_file(header.string(), program->header); !written) return written;
  if (auto written = replace_text_file(source.string(), program->source); !written) return written;
  console.print_message(fmt::format("wrote {} and {}, including a self-test", source.string(), header.string()));
  return {};
}

Result<void> fuse_one(Console& console, const std::string& path, const HealthyReference& healthy,
                      const FuseArguments& options) {
  const auto axes = load_axes(console, path, options);
  if (!axes) return failure(axes.error());
  if (!healthy.remark.empty() && path == options.runs.front()) console.print_message(healthy.remark);
  model::FusionOptions fusion = options.fusion;
  fusion.leave_out = !options.keep_all;
  fusion.healthy = healthy.rates;
  const auto run = fuse(*axes, healthy.thermometers, fusion);
  if (!run) return failure(run.error());
  if (!options.out.empty())
    if (auto written = write_csv(console, *axes, *run, options.out); !written) return written;
  if (!options.report.empty()) {
    if (auto written = report::write_fusion(*run, options.report, GYROTHERM_VERSION); !written) return written;
    console.print_message(options.report + "/fusion.html");
  }
  if (!options.export_c.empty())
    if (auto written = write_c(console, *run, options); !written) return written;
  std::string summary = console.json ? to_json(run->summary) : describe(run->summary, path);
  if (console.json && options.runs.size() > 1)
    summary = json_text(Json::parse(summary)) + "\n";  // one JSON record per line
  if (options.out == "-") {
    console.print_message(summary);
  } else {
    console.print_report(summary);
  }
  return {};
}

Result<Exit> fuse_all(Console& console, const FuseArguments& options) {
  if (options.folder.empty() && options.models.empty())
    return failure(FaultKind::usage, "--models", "name the folder that qualify wrote, or each model with --model");
  if (options.runs.size() > 1 && !(options.out.empty() && options.report.empty() && options.export_c.empty()))
    return failure(FaultKind::usage, "--out", "--out, --report and --export-c require a single record");
  if (auto free = check_outputs(options); !free) return failure(free.error());
  const auto healthy = learn_healthy(console, options);
  if (!healthy) return failure(healthy.error());
  for (const std::string& path : options.runs)
    if (auto fused = fuse_one(console, path, *healthy, options); !fused) return failure(fused.error());
  return Exit::done;
}

}  // namespace

void add_fuse(Program& program) {
  auto [command, options] = add_command(
      program, "fuse",
      "Combines three or more axes into one rate vector per second, and detects axes and thermometers whose readings "
      "contradict the others or the Earth rate.",
      "gyrotherm fuse random.db --models out --report out/fusion", fuse_all);
  command.add_option("runs", options.runs, "the records")->type_name(value::kRecord)->required();
  command
      .add_option("--models", options.folder,
                  "the folder with the model of each axis: UNIT/AXIS/model-NAME.json, or UNIT/model-NAME.json if the "
                  "unit has one axis")
      ->type_name(value::kFolder);
  command.add_option("--inputs", options.inputs, "NAME of the models in that folder (default: multi-point-t)")
      ->type_name("NAME");
  command.add_option("--model", options.models, "AXIS=FILE: the model of one axis, like u1.x=model.json")
      ->type_name("AXIS=MODEL");
  command.add_option("--axes", options.axes, "fuse only these axes, like u1.x,u1.y,u1.z")
      ->type_name("AXIS,…")
      ->delimiter(',');
  command
      .add_option("--healthy", options.healthy,
                  "a record without faults, from which the agreement of the thermometers and the scatter of the axes "
                  "are estimated (default: ramp.db in the folder of the models, for the thermometers only)")
      ->type_name(value::kRecord);
  command.add_option("--out", options.out, "table of the fused rate, one line per second; - for standard output")
      ->type_name(value::kTable);
  command.add_option("--report", options.report, "folder for fusion.html and fusion.json")
      ->check(reject_dash())
      ->type_name(value::kFolder);
  command
      .add_option("--export-c", options.export_c,
                  "C99 source that fuses one second; its header is written to the same folder")
      ->type_name(value::kCode);
  add_force_flag(command, options.force);
  command
      .add_option("--false-alarm", options.fusion.watch.false_alarm_probability,
                  "false-alarm probability of one test without a fault (default: 1e-6)")
      ->check(CLI::Range(1e-300, 0.5));
  command
      .add_option("--false-alarms-per-hour", options.fusion.watch.false_alarms_per_h,
                  "false alarms per hour of each cumulative sum without a fault (default: 0.001)")
      ->check(CLI::Range(1e-6, 3.0));
  command
      .add_option("--averaging", options.fusion.averaging_s,
                  "averaging time of the application in seconds; the axes are weighted for it (default: 100)")
      ->check(CLI::Range(1.0, 86400.0))
      ->type_name("SECONDS");
  command.add_flag("--keep-all", options.keep_all, "exclude an axis only in seconds with inconsistent readings");
  add_outside_option(command, options.outside);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
