// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "acquisition/exchange/export_choice.hpp"
#include "acquisition/exchange/gnuplot.hpp"
#include "acquisition/exchange/netcdf_export.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/row.hpp"
#include "analysis/data/dataset.hpp"
#include "analysis/model/stream.hpp"
#include "apps/console/command.hpp"
#include "apps/gyrotherm/compensation_table.hpp"
#include "apps/gyrotherm/follow.hpp"
#include "apps/gyrotherm/output_file.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/count_text.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

struct ExportArguments {
  std::string run, out, model, outside = "continue", format;
  std::string from, to, every;
  bool compensated = false;
  bool follow = false;
  bool force = false, unverified = false;
  data::AxisChoice axis;
};

/// Record of one axis with its compensated bias, one row per second.
struct CompensatedRows {
  data::Dataset dataset;
  Eigen::VectorXd compensated_deg_per_h{};
  double averaging_s{};
  Eigen::VectorXd expanded_deg_per_h{};  ///< empty without a budget
  std::string simulation{};              ///< virtual instruments; empty: none
};

/// Fails with usage unless rows are one second apart, because a model's means, rates and lags are defined in seconds.
/// An interval error of 1 % is accepted, because the clock of a logger may be inaccurate.
Result<void> check_one_row_per_second(const data::Dataset& dataset) {
  constexpr double kMaxIntervalError_s = 0.01;
  const double interval_s = data::sample_interval_s(dataset);
  if (std::abs(interval_s - 1) <= kMaxIntervalError_s) return {};
  return failure(FaultKind::usage, dataset.path,
                 fmt::format("--compensated requires one row per second, but these rows are {:g} s apart; {}",
                             interval_s, advice_for_spacing(interval_s)));
}

Result<CompensatedRows> compensate(Console& console, const record::RecordFiles& files, const ExportArguments& options) {
  const auto outside = model::parse_outside(options.outside);
  if (!outside) return failure(outside.error());
  const auto model = load_model(options.model);
  if (!model) return failure(model.error());
  auto dataset = data::load_dataset(files, axis_for(*model, options.axis));
  if (!dataset) return failure(dataset.error());
  if (auto checked = check_one_row_per_second(*dataset); !checked) return failure(checked.error());
  for (const std::string& warning : origin_warnings(*model, model::find_origin(*dataset)))
    console.print_message("warning: " + warning);
  auto stream = model::CompensationStream::open(*model, dataset->thermometers, *outside);
  if (!stream) return failure(stream.error());
  CompensatedRows rows{.dataset = std::move(*dataset), .averaging_s = model->cluster_length_s};
  rows.compensated_deg_per_h =
      stream->push_at(rows.dataset.time_s, rows.dataset.temperature_c, rows.dataset.bias_deg_per_h);
  if (model->uncertainty) {
    const auto expanded = [&](double excess) {
      return expanded_outside(*model->uncertainty, model->cluster_length_s, excess);
    };
    rows.expanded_deg_per_h = stream->excess().unaryExpr(expanded);
  }
  return rows;
}

tl::unexpected<Fault> no_rows_fault(const std::string& run) {
  return failure(FaultKind::usage, run, "the record has no row in the selected range");
}

bool has_row_at(const exchange::ExportChoice& choice, double time_s) {
  return !(choice.from && time_s < to_seconds(*choice.from)) && !(choice.to && time_s > to_seconds(*choice.to));
}

void add_number(std::string& text, double value) {
  text += ',';
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(text), "{}", value);
}

std::string format_table(const CompensatedRows& rows, const exchange::ExportChoice& choice) {
  const data::Dataset& dataset = rows.dataset;
  std::string text = rows.simulation.empty() ? "" : fmt::format("# SIMULATED: {}\n", plain(rows.simulation));
  text += fmt::format(
      "# run {}, {}; temperatures are calibrated, inputs of the model are their means over the last {:g} s"
      "\ntime [s]",
      dataset.run_id, dataset.bias_zero, rows.averaging_s);
  for (const std::string& input : dataset.thermometers)
    text += "," + input + (data::is_temperature(input) ? " [°C]" : "");
  text += fmt::format(",bias [°/h],compensated [°/h],U of a mean over {:g} s [°/h]\n", rows.averaging_s);
  for (Eigen::Index row = 0; row < dataset.moment_s.size(); ++row) {
    if (!has_row_at(choice, dataset.moment_s(row))) continue;
    fmt::format_to(std::back_inserter(text), "{}", dataset.moment_s(row));
    for (const double temperature : dataset.temperature_c.row(row)) add_number(text, temperature);
    add_number(text, dataset.bias_deg_per_h(row));
    add_number(text, rows.compensated_deg_per_h(row));
    const bool has_budget = rows.expanded_deg_per_h.size() > 0 && std::isfinite(rows.compensated_deg_per_h(row));
    add_number(text, has_budget ? rows.expanded_deg_per_h(row) : record::kMissing);
    text += '\n';
  }
  return text;
}

/// Returns the number of rows written.
Result<std::size_t> write_compensated(Console& console, const record::RecordFiles& files,
                                      const ExportArguments& options, const exchange::ExportChoice& choice,
                                      const record::RunInfo& info) {
  if (options.model.empty()) return failure(FaultKind::usage, "--compensated", "requires --model");
  if (options.format != "csv" || choice.every > Duration{})
    return failure(FaultKind::usage, "--compensated",
                   "writes one row per second as csv; not valid with --as or --every");
  auto rows = compensate(console, files, options);
  if (!rows) return failure(rows.error());
  rows->simulation = record::describe_simulation(info);
  const auto written =
      std::ranges::count_if(rows->dataset.moment_s, [&](double time_s) { return has_row_at(choice, time_s); });
  if (written == 0) return no_rows_fault(options.run);
  return replace_text_file(options.out, format_table(*rows, choice)).map([&] {
    return static_cast<std::size_t>(written);
  });
}

Result<exchange::ExportChoice> parse_choice(const ExportArguments& options, const record::RunInfo& info) {
  exchange::ExportChoice choice;
  const auto moment = [&](const std::string& text, const char* option, std::optional<Duration>& into) -> Result<void> {
    if (text.empty()) return {};
    const auto parsed = exchange::parse_moment(text, info, option);
    if (!parsed) return failure(parsed.error());
    into = *parsed;
    return {};
  };
  auto read =
      moment(options.from, "--from", choice.from).and_then([&] { return moment(options.to, "--to", choice.to); });
  if (!read) return failure(read.error());
  if (!options.every.empty()) {
    const auto every = parse_duration(options.every);
    if (!every || *every <= Duration{})
      return failure(FaultKind::usage, "--every", fmt::format("\"{}\", expected a time like \"10 s\"", options.every));
    choice.every = *every;
  }
  return exchange::check_choice(choice, info).map([&] { return choice; });
}

/// Writes the chosen rows as text table, NetCDF or gnuplot script. Returns their number.
Result<std::size_t> write_rows(const record::RecordFiles& files, const ExportArguments& options,
                               const exchange::ExportChoice& choice) {
  auto whole = record::read_record(files);
  if (!whole) return failure(whole.error());
  const auto chosen = exchange::chosen_rows(std::move(*whole), choice);
  if (chosen.slot.empty()) return no_rows_fault(options.run);
  const auto written =
      options.format == "netcdf"
          ? exchange::export_netcdf(chosen, choice, options.out)
          : replace_text_file(options.out,
                              options.format == "gnuplot" ? exchange::gnuplot_script(chosen) : record::to_csv(chosen));
  return written.map([&] { return chosen.slot.size(); });
}

Result<std::size_t> write_table(Console& console, const record::RecordFiles& files, const ExportArguments& options) {
  const auto info = record::read_info(files);
  if (!info) return failure(info.error());
  const auto choice = parse_choice(options, *info);
  if (!choice) return failure(choice.error());
  return options.compensated ? write_compensated(console, files, options, *choice, *info)
                             : write_rows(files, options, *choice);
}

/// Returns the ending of a file name with its dot, in lower case.
std::string find_ending(const std::string& file) {
  auto ending = std::filesystem::path(file).extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

/// Returns the format that --as names or, without it, the one that the ending of the file stands for. Fails with usage
/// if the two contradict each other.
Result<std::string> find_format(const ExportArguments& options) {
  static const std::map<std::string, std::string> endings{{".csv", "csv"},     {".nc", "netcdf"},
                                                          {".nc4", "netcdf"},  {".gp", "gnuplot"},
                                                          {".plt", "gnuplot"}, {".gnuplot", "gnuplot"}};
  const auto ending = find_ending(options.out);
  const auto known = endings.find(ending);
  static constexpr std::array kOther{".svg",  ".png",  ".pdf",  ".html", ".mat", ".h5",
                                     ".hdf5", ".json", ".toml", ".gz",   ".zip"};
  if (options.format.empty() && std::ranges::count(kOther, ending) > 0)
    return failure(FaultKind::usage, "--out",
                   fmt::format("no {} file can be written; expected FILE.csv, FILE.nc or FILE.gp", ending));
  if (options.format.empty()) return known == endings.end() ? "csv" : known->second;
  if (known == endings.end() || known->second == options.format) return options.format;
  return failure(FaultKind::usage, "--out",
                 fmt::format("{} has the ending of --as {}, but --as {} is given; expected another ending", options.out,
                             known->second, options.format));
}

Result<Exit> export_table(Console& console, const ExportArguments& given) {
  ExportArguments options = given;
  const bool is_chosen = !(options.from + options.to + options.every + options.format).empty();
  if (options.follow && (options.compensated || is_chosen || !options.out.empty()))
    return failure(
        FaultKind::usage, "--follow",
        "only prints recorded rows to stdout; not valid with --out, --as, --from, --to, --every or --compensated");
  if (options.follow) return follow_record(console, options.run).map([] { return Exit::done; });
  if (options.out.empty()) return failure(FaultKind::usage, "--out", "is missing; only --follow writes to stdout");
  for (const char* spreadsheet : {".xlsx", ".xls", ".ods"})
    if (find_ending(options.out) == spreadsheet)
      return failure(
          FaultKind::usage, "--out",
          fmt::format("no {} file can be written; write FILE.csv, which a spreadsheet program opens", spreadsheet));
  auto format = find_format(options);
  if (!format) return failure(format.error());
  options.format = std::move(*format);
  if (auto free = check_is_free(options.out, options.force); !free) return failure(free.error());
  const auto checked = check_recorded_run(console, options.run, options.unverified);
  if (!checked) return failure(checked.error());
  const auto rows = write_table(console, checked->files, options);
  if (!rows) return failure(rows.error());
  if (console.json)
    console.print(json_text(Json{{"file", options.out}, {"format", options.format}, {"rows", *rows}}) + "\n");
  else
    console.print_message(options.out + ": " + format_count(*rows, "row"));
  return Exit::done;
}

}  // namespace

void add_export(Program& program) {
  auto [command, options] =
      add_command(program, "export", "Exports a record as a text table, as NetCDF or as a figure.",
                  "gyrotherm export random.db --out random.csv", export_table);
  command.add_option("run", options.run, "the record")->type_name(value::kRecord)->required();
  command.add_option("--out", options.out, "the output file")->check(reject_dash())->type_name(value::kTable);
  add_force_flag(command, options.force);
  command
      .add_option("--as", options.format,
                  "output format: csv, netcdf (netCDF-4 with CF conventions) or gnuplot (a script with its data); "
                  "default: that of the ending of --out")
      ->check(CLI::IsMember({"csv", "netcdf", "gnuplot"}))
      ->type_name("FORMAT");
  command.add_option("--from", options.from, "the first row: \"2 h\" since the start, or \"2026-03-01T12:00:00Z\"")
      ->type_name("TIME");
  command.add_option("--to", options.to, "the last row, in the same form as --from")->type_name("TIME");
  command.add_option("--every", options.every, "averaging interval like \"10 s\"; pulses are summed")
      ->type_name("TIME");
  command.add_flag("--follow", options.follow,
                   "follow a run that is being written: print rows to stdout as they are recorded, until the run ends");
  auto* compensated =
      command.add_flag("--compensated", options.compensated,
                       "columns of one axis: calibrated temperatures, bias, compensated bias and its U");
  command.add_option("--model", options.model, "the compensation model")->type_name(value::kModel);
  add_outside_option(command, options.outside);
  add_axis_options(command, options.axis);
  for (const auto* of_it : {"--model", "--outside", "--unit", "--axis"}) command.get_option(of_it)->needs(compensated);
  add_unverified_flag(command, options.unverified);
}

}  // namespace gyrotherm::app
