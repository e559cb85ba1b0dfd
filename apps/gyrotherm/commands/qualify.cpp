// SPDX-License-Identifier: Apache-2.0
/// The command `qualify`: the whole experiment. It makes two runs and, for each axis of the rig, trains the three
/// models of the experiment and the recommended one, and writes a report. On request it compares all methods.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/status.hpp"
#include "analysis/model/qualification.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/qualify/axis_experiment.hpp"
#include "apps/gyrotherm/qualify/gyro_thermal.hpp"
#include "apps/gyrotherm/qualify/known_digests.hpp"
#include "apps/gyrotherm/qualify/lot_experiment.hpp"
#include "apps/gyrotherm/qualify/training_progress.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/report/calibration.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/carry_out.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/unit_identification.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
#include "report/report.hpp"
#include "sequencer/rig/unit_serials.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::app {
namespace {

struct QualifyArguments {
  std::string rig = "virtual", out, rate_profile = "qualification", random_profile = "random";
  std::vector<std::string> further;  ///< records
  std::vector<std::string> later;
  model::QualificationOptions training;
  std::uint64_t days_later{};
  bool compare = false;
  std::vector<std::string> only;  ///< axes to process; empty: all
  bool records_only = false;      ///< stops before training
  CalibrationArguments report;    ///< no report without texts
  IdentificationOptions identification;
};

/// Wall time of each stage. Not part of the results, because it differs between calls.
class Timings {
 public:
  /// Ends the previous stage, if any.
  void begin(std::string stage) {
    end();
    stages_.emplace_back(std::move(stage), 0.0);
    began_ = std::chrono::steady_clock::now();
    running_ = true;
  }
  void end() {
    if (running_)
      stages_.back().second = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    running_ = false;
  }
  /// Returns the stages in order with their seconds, and the peak memory of the process.
  [[nodiscard]] std::string to_json() const {
    Json json{{"schema", "gyrotherm-timings/1"}, {"stages", Json::array()}};
    double total = 0;
    for (const auto& [stage, seconds] : stages_) {
      json["stages"].push_back({{"stage", stage}, {"wall_s", seconds}});
      total += seconds;
    }
    json["total_wall_s"] = total;
    json["peak_memory_mb"] = peak_memory_mb();
    return json.dump(1) + "\n";
  }
  [[nodiscard]] std::string describe() const {
    std::string text;
    for (const auto& [stage, seconds] : stages_) text += fmt::format("  {:<52} {:8.1f} s\n", stage, seconds);
    return text + fmt::format("  {:<52} {:8.0f} MB\n", "peak memory", peak_memory_mb());
  }

 private:
  std::vector<std::pair<std::string, double>> stages_;
  std::chrono::steady_clock::time_point began_{};
  bool running_ = false;
};

/// Run of the experiment: its plan and, once it exists, its record.
struct Run {
  std::string stage;  ///< "ramp", "random", "30 days later"
  std::string path;
  profile::Profile profile{};
  std::uint64_t days_later{};
  record::Record record{};
  /// Digest of the record's rows as `export` writes them.
  std::string sha256{};
  /// Digest of the record's file; empty if the record is not closed.
  std::string file_sha256{};
};

/// Returns whether the run is an existing record that --verify-later named. It may have any profile.
bool is_existing_record(const Run& run) { return run.profile.text.empty(); }

/// Returns whether a record has the units of the rig at the same positions.
bool has_same_units(const record::RunInfo& info, const rig::RigFile& rig) {
  return info.unused_units == rig.identification.unused &&
         std::ranges::equal(info.units, rig.units, {}, &record::UnitInfo::serial_number,
                            [](const rig::UnitSettings& unit) { return unit.info.serial_number; });
}

/// Returns whether the record belongs to this experiment.
bool belongs_to_experiment(const record::RunInfo& info, const profile::Profile& profile, const rig::RigFile& rig,
                           const StartOptions& start) {
  return info.profile_text == profile.text && info.rig_text == rig.text &&
         info.chamber_map_text == rig.chamber_map.text && info.gyro_model_text == rig.gyro_model.text &&
         info.analogue_map_texts == collect_analogue_map_texts(rig) &&
         info.thermometer_texts == collect_thermometer_texts(rig) && info.supply_texts == collect_supply_texts(rig) &&
         info.program_version == GYROTHERM_VERSION && has_same_units(info, rig) &&
         (!rig.simulated || (info.seed == start.seed && info.days_later == start.days_later));
}

/// Plans a later run. `what` is the number of days after `random` at which the random program is repeated, or the path
/// of an existing record.
Result<Run> plan_later(const std::string& what, const rig::RigFile& rig, const Run& random) {
  std::uint64_t days{};
  const auto [end, error] = std::from_chars(what.data(), what.data() + what.size(), days);
  const bool is_number = error == std::errc{} && end == what.data() + what.size();
  if (!is_number && !std::filesystem::exists(what))
    return failure(FaultKind::usage, "--verify-later",
                   fmt::format("\"{}\" is neither a number of days nor a record", what));
  if (!is_number) return Run{.stage = what, .path = what};
  if (!rig.simulated)
    return failure(FaultKind::usage, "--verify-later",
                   fmt::format("a real rig cannot wait {} days; name the record of a later run", days));
  if (days < 1 || days > simulator::kMaxDaysLater - random.days_later)
    return failure(FaultKind::usage, "--verify-later",
                   fmt::format("{} days, expected 1 to {}", days, simulator::kMaxDaysLater - random.days_later));
  return Run{.stage = fmt::format("{} days later", days),
             .path = fmt::format("{}-{}-days-later.db", random.path.substr(0, random.path.size() - 3), days),
             .profile = random.profile,
             .days_later = random.days_later + days};
}

/// Records a run, resumes an unfinished one, or does nothing if its record is complete.
Result<void> record_run(Console& console, const Run& run, const rig::RigFile& rig, const StartOptions& start) {
  if (!std::filesystem::exists(run.path)) return start_run(console, run.profile, rig, run.path, start);
  const auto info = record::read_info(run.path);
  if (!info) return failure(info.error());
  if (!belongs_to_experiment(*info, run.profile, rig, start))
    return failure(
        FaultKind::usage, run.path,
        "belongs to another experiment (profile, rig, units, seed, age or program differs); choose another --out");
  const auto status = record::read_status(run.path);
  if (!status) return failure(status.error());
  if (!status->finished) return resume_run(console, run.path, {});
  console.print_message(fmt::format("{}: already recorded", run.path));
  return {};
}

/// Reads the record of a run and sets its digests. If the digest is stored and `unit` is given, reads only that unit.
Result<void> load_rows(Console& console, Run& run, KnownDigests& digests, const std::string& unit = {}) {
  const auto known = digests.find(run.path);
  if (!known) return failure(known.error());
  auto rows = *known ? record::read_record(run.path, unit)
                     : check_recorded_run(console, run.path, false).and_then([](const CheckedRun& checked) {
                         return record::read_record(checked.files);
                       });
  if (!rows) return failure(rows.error());
  run.record = std::move(*rows);
  run.sha256 = *known ? (*known)->rows : digest_rows(run.record);
  auto file = *known ? Result<std::string>((*known)->file) : digests.store_rows(run.path, run.sha256);
  if (!file) return failure(file.error());
  run.file_sha256 = std::move(*file);
  return {};
}

/// Returns the unit of all axes, or an empty string if they belong to several units.
std::string common_unit(const std::vector<data::AxisChoice>& axes) {
  const bool is_one = !axes.empty() && std::ranges::all_of(axes, [&](const data::AxisChoice& axis) {
    return axis.unit == axes.front().unit;
  });
  return is_one ? axes.front().unit : "";
}

Result<Run> plan_run(const std::string& stage, const std::string& path, const std::string& profile,
                     const rig::RigFile& rig, const QualifyArguments& options) {
  auto read = read_profile(profile, &rig);
  if (!read) return failure(read.error());
  if (auto checked = check_accept(*read, profile); !checked) return failure(checked.error());
  return Run{.stage = stage, .path = path, .profile = std::move(*read), .days_later = options.days_later};
}

/// Reads the records that are used to recommend a model. Called before anything moves, because a run takes days and a
/// wrong file name should be reported first.
Result<std::vector<data::RecordedRun>> load_further_records(Console& console, const std::vector<std::string>& paths,
                                                            const profile::Profile& rate) {
  const auto loaded = load_recorded_runs(console, paths, {});
  if (!loaded) return failure(loaded.error());
  std::vector<data::RecordedRun> further;
  for (std::size_t k = 0; k < loaded->datasets.size(); ++k)
    further.push_back({loaded->datasets[k], loaded->clusters[k]});
  if (const auto other = model::check_profiles(rate.name, further); !other) return failure(other.error());
  return further;
}

/// The runs of one experiment: the ramp run, the random run and any later runs.
struct Runs {
  Run rate, random;
  std::vector<Run> later;
};

Result<ExperimentRun> single_axis_run(const Run& run) {
  return data::choose_axis(run.record.info, {}, run.path)
      .and_then([&](const data::AxisChoice& of) { return extract_axis(run.record, run.path, of); })
      .map([&](data::RecordedRun recorded) {
        return ExperimentRun{.stage = run.stage,
                             .profile = run.profile,
                             .days_later = run.days_later,
                             .recorded = std::move(recorded),
                             .sha256 = run.sha256,
                             .file_sha256 = run.file_sha256};
      });
}

/// Assembles the experiment of a rig with one axis.
Result<AxisExperiment> single_axis_experiment(const Runs& runs, std::vector<data::RecordedRun> further) {
  auto rate = single_axis_run(runs.rate);
  if (!rate) return failure(rate.error());
  auto random = single_axis_run(runs.random);
  if (!random) return failure(random.error());
  AxisExperiment experiment{
      .rate = std::move(*rate), .random = std::move(*random), .later = {}, .further = std::move(further)};
  for (const Run& run : runs.later) {
    auto later = single_axis_run(run);
    if (!later) return failure(later.error());
    experiment.later.push_back(std::move(*later));
  }
  return experiment;
}

std::string result_table(const report::Report& report, const model::Qualification& qualification) {
  const auto row = [](std::string_view what, const std::string& rate, const std::string& cycle,
                      const std::string& random, const std::string& size, const std::string& training) {
    return fmt::format("{:<30} {:>9} {:>9} {:>9} {:>8} {:>8}\n", what, rate, cycle, random, size, training);
  };
  const auto number = [](double std) { return fmt::format("{:.5f}", std); };
  auto text = std::string(report.rig.is_virtual ? "SIMULATED\n" : "");
  text += row("", "ramp,", "held-out", "random,", "", "");
  text += row("STD, °/h", "fitted", "cycle", "unseen", "numbers", "train, s");
  text += row("raw", number(report.rate.raw.std), "", number(report.random.raw.std), "", "");
  const auto add = [&](const model::TrainedModel& trained) {
    const model::Model& model = trained.model;
    text += row(fmt::format("{:<13} {}", model.method, model.inputs), number(trained.rate.compensated.std),
                number(model.leave_cycle_out.std), number(trained.random.compensated.std),
                fmt::format("{}", stored_numbers(model)), fmt::format("{:.1f}", trained.training_s));
  };
  for_each_model(qualification.models, [&](const char*, const model::TrainedModel& trained) { add(trained); });
  std::ranges::for_each(qualification.comparison.models, add);
  text += row("noise floor", number(report.rate.floor.deg_per_h), "", number(report.random.floor.deg_per_h), "", "");
  const model::Recommendation& found = report.recommendation;
  return text +
         fmt::format("recommended: {}{}\n", found.recommended.empty() ? "" : found.recommended + ", ", found.statement);
}

/// Returns the table of residual errors on the later runs, or an empty text without such runs.
std::string later_table(const report::Report& report) {
  if (report.later.empty()) return "";
  std::string text = fmt::format("{:<39} {:>20}", "RMSE, °/h (inside the 95 % intervals)", "random");
  for (const report::ReportedLaterRun& run : report.later) text += fmt::format(" {:>20}", run.name);
  const auto cell = [](const report::ReportedVerification& found) {
    const std::string share = found.coverage ? fmt::format(" ({:5.1f} %)", 100 * found.coverage->seen) : "";
    return fmt::format(" {:>20}", fmt::format("{:.5f}{}", found.figures.rmse, share));
  };
  for (const report::ReportedMethod& method : report.methods) {
    text += fmt::format("\n{:<39}{}", fmt::format("{:<13} {}", method.method, method.inputs), cell(method.random));
    for (const report::ReportedVerification& later : method.later) text += cell(later);
  }
  return text + "\n";
}

/// Returns three lines: the result, its uncertainty, and the file of the report.
std::string summarise(const report::Report& report, const model::Qualification& trained, const std::string& path) {
  const auto& methods = report.methods;
  const auto found = std::ranges::find(methods, report.recommendation.recommended, &report::ReportedMethod::name);
  if (found == methods.end()) return fmt::format("report:      {}\n", path);
  const report::ReportedVerification& unseen = found->random;
  // The model's own value, because it counts only the clusters with a residual.
  double raw_std = report.random.raw.std;
  for_each_trained(trained, [&](const std::string& name, const model::TrainedModel& model) {
    if (name == found->name) raw_std = model.random.raw.std;
  });
  std::string text =
      fmt::format("result:      {} on {} lowers the STD of an unseen run from {:.5f} to {:.5f} °/h{}\n", found->method,
                  found->inputs, raw_std, unseen.figures.std, report.rig.is_virtual ? " (SIMULATED)" : "");
  if (found->uncertainty)
    text += fmt::format("uncertainty: U = {:.5f} °/h (k = {:.2f})", found->uncertainty->expanded_deg_per_h,
                        found->uncertainty->coverage_factor);
  if (found->uncertainty && unseen.coverage)
    text += fmt::format("; {:.1f} % of the unseen means lie within their {:.0f} % intervals",
                        100 * unseen.coverage->seen, 100 * unseen.coverage->nominal);
  return text + (found->uncertainty ? "\n" : "") + fmt::format("report:      {}\n", path);
}

/// Writes the calibration report of the units with the trained models, if a laboratory or an order was named.
Result<void> write_calibration_report(Console& console, const QualifyArguments& options, Timings& timings) {
  if (options.report.laboratory.empty() && options.report.order.empty()) return {};
  timings.begin("calibration report");
  CalibrationArguments report = options.report;
  report.runs = {record::ramp_record_path(options.out), options.out + "/random.db"};
  report.left_folder = options.out;
  report.out = options.out + "/calibration";
  if (auto written = calibrate(console, report); !written) return failure(written.error());
  return {};
}

/// Writes the files that follow the training: the calibration report and timings.json.
Result<void> write_report_and_timings(Console& console, const QualifyArguments& options, Timings& timings) {
  if (auto written = write_calibration_report(console, options, timings); !written) return written;
  timings.end();
  return replace_text_file(options.out + "/timings.json", timings.to_json());
}

Result<Exit> print_outcome(Console& console, const QualifyArguments& options, const AxisOutcome& outcome,
                           Timings& timings) {
  const auto& [trained, report] = outcome;
  if (auto written = write_report_and_timings(console, options, timings); !written) return failure(written.error());
  console.print_report(console.json ? to_json(report) : result_table(report, trained) + later_table(report));
  for (const report::AcceptedLimit& limit : report.accept)
    if (!limit.passed)
      console.print_message(fmt::format("FAIL: {} is {:.5g}, limit {:.5g}", limit.figure, limit.value, limit.limit));
  auto last = timings.describe() + summarise(report, trained, options.out + "/report/report.html");
  last.pop_back();
  console.print_message(last);
  return overall_verdict(report) == "FAIL" ? Exit::outside_limits : Exit::done;
}

using FutureThermalModel = std::future<Result<report::ReportedThermal>>;

/// Waits for the thermal model, or computes it now.
Result<report::ReportedThermal> load_thermal_model(FutureThermalModel& thermal, Timings& timings) {
  timings.begin("thermal image");
  return thermal.get();
}

Result<Exit> qualify_one_axis(Console& console, const QualifyArguments& options, const rig::RigFile& rig,
                              const Runs& runs, std::vector<data::RecordedRun> further, FutureThermalModel& future,
                              Timings& timings) {
  auto thermal = load_thermal_model(future, timings);
  if (!thermal) return failure(thermal.error());
  auto experiment = single_axis_experiment(runs, std::move(further));
  if (!experiment) return failure(experiment.error());
  std::vector<std::string> warnings;
  const AxisOptions axis_options{.folder = options.out,
                                 .compare = options.compare || !experiment->further.empty(),
                                 .training = options.training,
                                 .thermal = std::move(*thermal),
                                 .on_stage = [&](const std::string& stage) { timings.begin(stage); }};
  TrainingProgress progress(
      console.sink(),
      {.compares = axis_options.compare, .quick = options.training.quick, .nested = options.training.nested});
  const auto outcome = carry_out(*experiment, rig, axis_options, std::ref(progress), warnings);
  if (!outcome) return failure(outcome.error());
  for (const std::string& warning : warnings) console.print_message(warning);
  return print_outcome(console, options, *outcome, timings);
}

LotRun lot_run(Run run) {
  return {.stage = std::move(run.stage),
          .path = std::move(run.path),
          .profile = std::move(run.profile),
          .days_later = run.days_later,
          .record = std::move(run.record),
          .sha256 = std::move(run.sha256),
          .file_sha256 = std::move(run.file_sha256)};
}

Result<Exit> qualify_lot(Console& console, const QualifyArguments& options, const rig::RigFile& rig, Runs runs,
                         std::vector<data::AxisChoice> only, FutureThermalModel& future, Timings& timings) {
  auto thermal = load_thermal_model(future, timings);
  if (!thermal) return failure(thermal.error());
  const auto axes = only.empty() ? data::list_axes(runs.rate.record.info).size() : only.size();
  const bool is_whole = only.empty();
  LotExperiment lot{.out = options.out,
                    .rate = lot_run(std::move(runs.rate)),
                    .random = lot_run(std::move(runs.random)),
                    .later = {},
                    .compare = options.compare,
                    .only = std::move(only),
                    .training = options.training,
                    .thermal = std::move(*thermal)};
  for (Run& run : runs.later) lot.later.push_back(lot_run(std::move(run)));
  timings.begin(fmt::format("train {} axes", axes));
  const auto summary = carry_out(console, lot, rig);
  if (!summary) return failure(summary.error());
  if (is_whole)
    if (auto written = write_report_and_timings(console, options, timings); !written) return failure(written.error());
  console.print_report(console.json ? to_json(*summary) : describe(*summary));
  if (is_whole) console.print_message(timings.describe() + options.out + "/lot.html");
  return overall_verdict(*summary) == "FAIL" ? Exit::outside_limits : Exit::done;
}

/// Returns the number of runs to record at the same time. Runs on a real rig share its chamber. With --json, each run
/// prints facts that do not name it.
std::size_t parallel_runs(const Console& console, const QualifyArguments& options, const rig::RigFile& rig) {
  if (!rig.simulated || console.json) return 1;
  return options.training.threads > 0 ? static_cast<std::size_t>(options.training.threads)
                                      : std::max(1U, std::thread::hardware_concurrency());
}

/// Calls `work` for all runs, on up to `threads` threads that include the calling one. Begins no further run after a
/// fault, and returns the fault of the first run that has one.
Result<void> for_each_run(const std::vector<Run*>& runs, std::size_t threads,
                          const std::function<Result<void>(Run&)>& work) {
  std::vector<Result<void>> results(runs.size());
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  const auto work_until_done = [&] {
    for (auto k = next++; k < runs.size() && !failed; k = next++) {
      results[k] = work(*runs[k]);
      if (!results[k]) failed = true;
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < std::min(threads, runs.size()); ++i)
      others.emplace_back([&] {
        block_signals();
        work_until_done();
      });
    work_until_done();
  }
  const auto first = std::ranges::find_if(results, [](const Result<void>& result) { return !result; });
  return first == results.end() ? Result<void>() : *first;
}

/// Records the missing runs and reads all runs. Reads only one unit if all axes of `only` belong to it.
Result<void> record_and_load(Console& console, const QualifyArguments& options, const rig::RigFile& rig,
                             const std::vector<data::AxisChoice>& only, KnownDigests& digests, Runs& runs,
                             Timings& timings) {
  std::vector<Run*> all{&runs.rate, &runs.random};
  for (Run& run : runs.later)
    if (!is_existing_record(run)) all.push_back(&run);
  const std::size_t threads = parallel_runs(console, options, rig);
  timings.begin(fmt::format("record {} runs", all.size()));
  const auto recorded = for_each_run(all, threads, [&](Run& run) {
    return record_run(console, run, rig, {.seed = options.training.seed, .days_later = run.days_later});
  });
  if (!recorded) return recorded;
  watch_for_interrupts(SecondInterrupt::ends);  // no chamber is driven any more
  timings.begin("read records");
  return for_each_run(all, threads, [&](Run& run) { return load_rows(console, run, digests, common_unit(only)); });
}

Result<Runs> plan_runs(const QualifyArguments& options, const rig::RigFile& rig) {
  auto rate = plan_run("ramp", record::ramp_record_path(options.out), options.rate_profile, rig, options);
  if (!rate) return failure(rate.error());
  auto random = plan_run("random", options.out + "/random.db", options.random_profile, rig, options);
  if (!random) return failure(random.error());
  Runs runs{.rate = std::move(*rate), .random = std::move(*random), .later = {}};
  for (const std::string& what : options.later) {
    auto planned = plan_later(what, rig, runs.random);
    if (!planned) return failure(planned.error());
    runs.later.push_back(std::move(*planned));
  }
  return runs;
}

bool has_one_axis(const rig::RigFile& rig) { return rig.units.size() == 1 && rig.units.front().info.axes.size() == 1; }

/// Returns the axes of --only, or an empty list without that option. Fails with usage.
Result<std::vector<data::AxisChoice>> requested_axes(const QualifyArguments& options, const rig::RigFile& rig) {
  if (!options.only.empty() && has_one_axis(rig))
    return failure(FaultKind::usage, "--only", "only valid for a rig with several axes; this rig has one");
  record::RunInfo info;
  info.units = list_units_in_use(rig);
  return find_axes(options.only, info);
}

/// Identifies the units of a new experiment. An experiment that has begun keeps its units.
Result<void> identify_units(Console& console, const QualifyArguments& options, const Run& first, rig::RigFile& rig) {
  if (std::filesystem::exists(first.path)) return keep_units_of_record(rig, options.identification.units, first.path);
  const StartOptions start{.seed = options.training.seed, .days_later = first.days_later};
  if (auto may = check_may_start(rig, first.path, start); !may) return may;
  auto identification = options.identification;
  identification.order = options.report.order;
  return identify_units(console, rig, identification, {first.path, first.profile.name, parent_folder(options.out)});
}

Result<Exit> qualify(Console& console, const QualifyArguments& options) {
  auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  if (auto texts = check_report_texts(options.report, {}, options.rig); !texts) return failure(texts.error());
  auto runs = plan_runs(options, *rig);
  if (!runs) return failure(runs.error());
  if (auto named = identify_units(console, options, runs->rate, *rig); !named) return failure(named.error());
  if (auto texts = check_report_texts(options.report, list_units_in_use(*rig), options.rig); !texts)
    return failure(texts.error());
  if (!options.further.empty() && !has_one_axis(*rig))
    return failure(FaultKind::usage, "--further",
                   "only valid for a rig with one axis; otherwise use \"gyrotherm train --unit\" for each unit");
  auto further = load_further_records(console, options.further, runs->rate.profile);
  if (!further) return failure(further.error());
  auto only = requested_axes(options, *rig);
  if (!only) return failure(only.error());
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) return failure(FaultKind::storage, options.out, "cannot be created: " + error.message());
  KnownDigests digests(options.out, GYROTHERM_VERSION);
  for (Run& run : runs->later)
    if (auto loaded = is_existing_record(run) ? load_rows(console, run, digests) : Result<void>(); !loaded)
      return failure(loaded.error());
  watch_for_interrupts(rig->simulated ? SecondInterrupt::ends : SecondInterrupt::is_counted);
  if (rig->simulated)
    console.print_message(
        fmt::format("SIMULATED: {}, seed {}{}", rig->title, options.training.seed,
                    options.days_later > 0 ? fmt::format(", {} days later", options.days_later) : ""));

  // The image is computed beside the recording of a virtual rig. The destructor waits for it.
  const bool is_at_once = !options.records_only && parallel_runs(console, options, *rig) > 1;
  FutureThermalModel thermal =
      std::async(is_at_once ? std::launch::async : std::launch::deferred, [&rig] { return find_thermal_model(*rig); });
  Timings timings;
  if (auto loaded = record_and_load(console, options, *rig, *only, digests, *runs, timings); !loaded)
    return failure(loaded.error());
  if (options.records_only) return Exit::done;
  if (!has_one_axis(*rig))
    return qualify_lot(console, options, *rig, std::move(*runs), std::move(*only), thermal, timings);
  return qualify_one_axis(console, options, *rig, *runs, std::move(*further), thermal, timings);
}

}  // namespace

void add_qualify(Program& program) {
  auto [command, options] = add_command(
      program, "qualify",
      "Carries out the whole experiment: the ramp run, the random run, the training of three models and of the "
      "recommended one, and the report. A second call resumes it. On a rig with several axes, each axis has its own "
      "models and report, and the lot has a summary; with --laboratory or --order each unit also has a calibration "
      "report.",
      "gyrotherm qualify --out out", qualify);
  options.training.program_version = GYROTHERM_VERSION;
  command.add_option("--out", options.out, "the folder for all results")
      ->check(reject_dash())
      ->type_name(value::kFolder)
      ->required();
  command.add_option("--rig", options.rig, "the rig (default: virtual, a dry run)")->type_name(value::kRig);
  command
      .add_option("--seed", options.training.seed,
                  "seed of the virtual gyro, its noise and the swarm; 0: the gyro of the file")
      ->check(not_negative());
  add_days_later_option(command, options.days_later);
  command
      .add_option("--threads", options.training.threads,
                  "threads of virtual runs and of the training; 0: all; the result is the same")
      ->check(not_negative());
  command.add_flag("--compare", options.compare, "also train all other methods, and compare them in the report");
  command
      .add_option("--only", options.only,
                  "on a rig with several axes: train only these axes or units; a later call without --only writes "
                  "the summary of the lot")
      ->type_name("UNIT[.AXIS],…")
      ->delimiter(',');
  command.add_flag("--records-only", options.records_only,
                   "make and verify the missing records and exit; a later call trains the models");
  command.add_flag("--quick", options.training.quick, "small swarm, for a trial; the report states it");
  command.add_flag(
      "--nested", options.training.nested,
      "nested cross-validation: repeat all choices without each held-out cycle; training takes about twice as long");
  command
      .add_option("--further", options.further,
                  "further records of this gyro, with a different profile from the ramp run; all methods are trained, "
                  "and the recommended model is selected on them by the rule in docs/evaluation.md, never on the run "
                  "that the report quotes")
      ->type_name(value::kRecord);
  command
      .add_option("--verify-later", options.later,
                  "also verify every model on later runs: days like 30,365 repeat the random run on a virtual gyro of "
                  "that age; or name records of later runs of this gyro")
      ->type_name("DAYS,…|RECORD")
      ->delimiter(',');
  add_report_texts(command, options.report);
  add_identification_options(command, options.identification);
  command.add_option("--rate-profile", options.rate_profile, "profile of the ramp run (default: qualification)")
      ->type_name(value::kProfile);
  command.add_option("--random-profile", options.random_profile, "profile of the random run (default: random)")
      ->type_name(value::kProfile);
}

}  // namespace gyrotherm::app
