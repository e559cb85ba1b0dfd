// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/report/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <future>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "acquisition/record/chain.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/model/making.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "apps/gyrotherm/report/calibration_folder.hpp"
#include "apps/gyrotherm/report/calibration_source.hpp"
#include "apps/gyrotherm/report/draft_check.hpp"
#include "apps/gyrotherm/standard/check_record.hpp"
#include "core/clock.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "report/calibration_results.hpp"
#include "report/dcc.hpp"
#include "report/draft.hpp"
#include "report/order.hpp"
#include "report/report.hpp"

namespace gyrotherm::app {
namespace {

constexpr std::size_t kLargestRecord = 4'000'000'000;

/// Verified record. Its rows are read later, unit by unit: the rows of a whole lot would not fit into memory.
struct CheckedRecord {
  record::RecordFiles files;
  std::string sha256;
  bool chain_verified{};
  record::RunInfo info;
  std::vector<report::UsedFile> parts;
};

Result<std::vector<report::UsedFile>> list_parts(const record::RecordFiles& files) {
  std::vector<report::UsedFile> parts;
  for (const record::Part& part : files.parts) {
    if (part.continuation.part < 2) continue;
    const auto digest = record::file_digest(part.path, kLargestRecord);
    if (!digest) return failure(digest.error());
    parts.push_back({.role = "record_part", .name = record::name_in_folder(part.path), .sha256 = *digest});
  }
  return parts;
}

Result<CheckedRecord> check(Console& console, const std::string& path, bool unverified) {
  auto checked = check_recorded_run(console, path, unverified);
  if (!checked) return failure(checked.error());
  auto& [files, verified] = *checked;
  auto info = record::read_info(files);
  if (!info) return failure(info.error());
  auto digest = verified.manifest ? verified.digest : record::file_digest(path, kLargestRecord);
  if (!digest) return failure(digest.error());
  auto parts = list_parts(files);
  if (!parts) return failure(parts.error());
  return CheckedRecord{std::move(files), std::move(*digest), !unverified, std::move(*info), std::move(*parts)};
}

/// Returns why two records of one run id are refused. The id of a virtual run is derived from profile, seed and day.
std::string describe_repetition(const CheckedRecord& first, const CheckedRecord& second) {
  if (!second.info.virtual_rig || first.sha256 == second.sha256) return "the same run is given twice";
  return fmt::format(
      "is a virtual run of the same profile, seed and day as {}: both are one virtual measurement; make another run "
      "with --days-later or --seed",
      first.files.path);
}

Result<std::vector<CheckedRecord>> check_records(Console& console, const CalibrationArguments& options) {
  std::vector<CheckedRecord> records;
  for (const std::string& path : options.runs) {
    auto one = check(console, path, options.unverified);
    if (!one) return failure(one.error());
    const auto same =
        std::ranges::find_if(records, [&](const CheckedRecord& other) { return other.info.id == one->info.id; });
    if (same != records.end()) return failure(FaultKind::usage, path, describe_repetition(*same, *one));
    records.push_back(std::move(*one));
  }
  return records;
}

/// Reads the rows of one unit from all records, in their order.
Result<std::vector<record::Record>> read_records(const std::vector<CheckedRecord>& records, const std::string& unit) {
  std::vector<record::Record> all;
  for (const CheckedRecord& one : records) {
    auto record = record::read_record(one.files, unit);
    if (!record) return failure(record.error());
    if (!record->finished)
      return failure(FaultKind::usage, one.files.path, "the run has not finished; \"gyrotherm resume\" completes it");
    all.push_back(std::move(*record));
  }
  return all;
}

std::vector<std::string> units_in(const record::RunInfo& info) {
  std::vector<std::string> names;
  for (const record::UnitInfo& unit : info.units)
    if (!is_unused(info, unit.name)) names.push_back(unit.name);
  return names;
}

/// Returns the units to report. Fails with usage if a record does not contain one of them.
Result<std::vector<std::string>> units_to_report(const std::vector<CheckedRecord>& records,
                                                 const std::string& requested) {
  std::vector<std::string> units = units_in(records.front().info);
  if (!requested.empty()) units = {requested};
  for (const CheckedRecord& one : records) {
    for (const std::string& unit : units)
      if (find_unit(one.info, unit) == nullptr)
        return failure(FaultKind::usage, one.files.path,
                       fmt::format("has no unit \"{}\"; its units are {}", unit, fmt::join(units_in(one.info), ", ")));
  }
  return units;
}

/// Model and its file.
struct ModelOfAxis {
  model::Model model;
  report::UsedFile file;
};

Result<ModelOfAxis> load_model_of_axis(const std::string& path, const char* role) {
  const auto text = read_text_file(path, kLargestTable);
  if (!text) return failure(text.error());
  auto model = model::model_from_json(*text, path);
  if (!model) return failure(model.error());
  report::UsedFile file{.role = role,
                        .name = std::filesystem::path(path).filename().string(),
                        .sha256 = sha256(*text),
                        .program_version = model->program_version};
  return ModelOfAxis{std::move(*model), std::move(file)};
}

/// Models of a stage, from named files or from a folder.
struct ModelSource {
  std::vector<ModelOfAxis> named;
  std::string folder;
  const char* role;
};

Result<ModelSource> load_models(const std::vector<std::string>& files, const std::string& folder, const char* role) {
  ModelSource source{{}, folder, role};
  for (const std::string& path : files) {
    auto model = load_model_of_axis(path, role);
    if (!model) return failure(model.error());
    source.named.push_back(std::move(*model));
  }
  return source;
}

/// Returns whether a model applies to an axis. A model of a record with a single axis applies to any axis.
bool applies_to(const model::Model& model, const data::AxisChoice& axis) {
  return model.trained_on.empty() || !is_named(model.trained_on.front().of) || model.trained_on.front().of == axis;
}

/// Returns the name of the models in folders.
std::string model_inputs(const CalibrationArguments& options) {
  return options.inputs.empty() ? "multi-point-t" : options.inputs;
}

/// Returns the first named model that applies to an axis, otherwise the model in the folder. Returns nothing if no
/// named model applies and there is no folder.
Result<std::optional<ModelOfAxis>> find_model(const ModelSource& source, const std::string& inputs,
                                              const data::AxisChoice& axis) {
  for (const ModelOfAxis& one : source.named)
    if (applies_to(one.model, axis)) return std::optional(one);
  if (source.folder.empty()) return std::optional<ModelOfAxis>();
  auto model = load_model_of_axis(model_path(source.folder, axis, inputs), source.role);
  if (!model) return failure(model.error());
  return std::optional(std::move(*model));
}

/// Fails with usage if two named models apply to an axis.
Result<void> check_one_model(const ModelSource& source, const data::AxisChoice& axis, const char* option) {
  const ModelOfAxis* first = nullptr;
  for (const ModelOfAxis& one : source.named) {
    if (!applies_to(one.model, axis)) continue;
    if (first != nullptr)
      return failure(FaultKind::usage, option,
                     fmt::format("{} and {} apply to one axis, {}{}{}; expected one model per axis", first->file.name,
                                 one.file.name, axis.unit, axis.axis.empty() ? "" : ".", axis.axis));
    first = &one;
  }
  return {};
}

/// Fails with usage if a named model applies to no axis of the reported units, or two to the same axis.
Result<void> check_models_apply(const std::vector<CheckedRecord>& records, const std::vector<std::string>& units,
                                const ModelSource& source) {
  const char* const option = std::string_view(source.role) == "model_left" ? "--model" : "--found";
  for (const std::string& name : units)
    for (const auto& axis : find_unit(records.front().info, name)->axes)
      if (auto one = check_one_model(source, {name, axis.name}, option); !one) return one;
  for (const ModelOfAxis& one : source.named) {
    bool applies = false;
    for (const std::string& name : units)
      for (const auto& axis : find_unit(records.front().info, name)->axes)
        applies = applies || applies_to(one.model, {name, axis.name});
    if (applies) continue;
    const data::AxisChoice& of = one.model.trained_on.front().of;
    return failure(FaultKind::usage, option,
                   fmt::format("{} was trained on {}{}{}, which is not reported; the reported units are {}",
                               one.file.name, of.unit, of.axis.empty() ? "" : ".", of.axis, fmt::join(units, ", ")));
  }
  return {};
}

/// Parses a file if its path is given.
template <class T>
Result<std::optional<T>> parse_if_given(const std::string& path,
                                        Result<T> (*parse)(std::string_view text, const std::string& file)) {
  if (path.empty()) return std::optional<T>();
  const auto text = read_text_file(path);
  if (!text) return failure(text.error());
  auto parsed = parse(*text, path);
  if (!parsed) return failure(parsed.error());
  return std::optional(std::move(*parsed));
}

/// Input of all reports.
struct ReportInput {
  std::optional<report::LaboratoryFile> laboratory;
  std::optional<report::OrderFile> order;
  std::vector<CheckedRecord> records;
  ModelSource found, left;
};

Result<ReportInput> load_all(Console& console, const CalibrationArguments& options) {
  auto laboratory = parse_if_given(options.laboratory, report::parse_laboratory);
  if (!laboratory) return failure(laboratory.error());
  auto order = parse_if_given(options.order, report::parse_order);
  if (!order) return failure(order.error());
  auto records = check_records(console, options);
  if (!records) return failure(records.error());
  auto found = load_models(options.found, options.found_folder, "model_found");
  if (!found) return failure(found.error());
  auto left = load_models(options.left, options.left_folder, "model_left");
  if (!left) return failure(left.error());
  return ReportInput{std::move(*laboratory), std::move(*order), std::move(*records), std::move(*found),
                     std::move(*left)};
}

/// Returns the folder where qualify wrote the results of an axis, which is the folder of its model.
std::string experiment_folder(const CalibrationArguments& options, const data::AxisChoice& axis) {
  if (options.left_folder.empty()) return {};
  return std::filesystem::path(model_path(options.left_folder, axis, model_inputs(options))).parent_path().string();
}

bool is_plane(const std::string& method) {
  return method == "linear" || method == "ridge" || method == "ridge-u" || method == "stepwise";
}

report::ComparedModel make_compared_model(const report::ReportedMethod& method, const std::string& axis) {
  return {.axis = axis,
          .inputs = method.inputs,
          .method = method.method,
          .rmse_deg_per_h = method.random.figures.rmse,
          .std_deg_per_h = method.random.figures.std,
          .expanded_deg_per_h = method.uncertainty ? method.uncertainty->expanded_deg_per_h : report::kNotKnown};
}

/// Adds models of the experiment for comparison: the as-left model, the best linear model and the recommended model.
void add_compared(report::CalibrationReport& report, const report::Report& experiment, const std::string& axis,
                  const model::Model& left) {
  const report::ReportedMethod* simplest = nullptr;
  for (const report::ReportedMethod& method : experiment.methods)
    if (is_plane(method.method) && (simplest == nullptr || method.random.figures.rmse < simplest->random.figures.rmse))
      simplest = &method;
  for (const report::ReportedMethod& method : experiment.methods) {
    report::ComparedModel one = make_compared_model(method, axis);
    one.left = method.inputs == left.inputs && method.method == left.method;
    one.recommended = method.name == experiment.recommendation.recommended;
    one.simple = &method == simplest;
    if (one.left || one.recommended || one.simple) report.compared.push_back(std::move(one));
  }
}

Result<void> add_experiment(report::CalibrationReport& report, const std::string& folder, const std::string& axis,
                            const model::Model& left) {
  const std::string path = folder + "/report/report.json";
  const auto text = read_text_file_if_any(path, kLargestTable);
  if (!text) return failure(text.error());
  if (!*text) return {};
  const auto experiment = report::read_report(**text, path);
  if (!experiment) return failure(experiment.error());
  add_compared(report, *experiment, axis, left);
  return {};
}

void add_file(report::CalibrationReport& report, const std::optional<ModelOfAxis>& model) {
  if (model) report.files.push_back(model->file);
}

/// Moves the model out of `model`. Its file entry is no longer needed, because the report already names the file.
std::optional<model::Model> take_model(std::optional<ModelOfAxis>& model) {
  return model ? std::optional(std::move(model->model)) : std::nullopt;
}

void add_trained_range(report::CalibrationReport& report, const std::string& axis, report::Stage stage,
                       const std::optional<model::Model>& model) {
  if (model) report.trained_ranges.push_back({axis, stage, model::trained_block(model->trained_on)});
}

Result<void> add_axis(report::CalibrationReport& report, const ReportInput& given,
                      const std::vector<record::Record>& records, const data::AxisChoice& choice,
                      const std::string& label, const CalibrationArguments& options) {
  report::CalibratedAxis axis{.label = label};
  std::vector<model::ReadingsSample> sampled;
  for (std::size_t i = 0; i < records.size(); ++i) {
    auto dataset = data::make_dataset(records[i], given.records[i].files.path, choice);
    auto clusters = data::make_clusters(dataset);
    if (!clusters) return failure(clusters.error());
    if (auto distinct = model::check_distinct(dataset, *clusters, sampled); !distinct) return distinct;
    sampled.push_back(model::sample_readings(dataset, *clusters));
    if (i > 0) {
      const data::Dataset& first = axis.runs.front().dataset;
      if (auto one = check_same_gyro(dataset, first, first.path, "; a report covers one gyro"); !one) return one;
    }
    report.bias_zeros.push_back({label, dataset.run_id, dataset.bias_zero});
    report.cluster_length_s = clusters->length_s;
    for (std::string& name : data::block_thermometers(dataset))
      if (std::ranges::find(report.block_thermometers, name) == report.block_thermometers.end())
        report.block_thermometers.push_back(std::move(name));
    axis.runs.push_back({std::move(dataset), std::move(*clusters)});
  }
  auto found = find_model(given.found, model_inputs(options), choice);
  if (!found) return failure(found.error());
  auto left = find_model(given.left, model_inputs(options), choice);
  if (!left) return failure(left.error());
  add_file(report, *found);
  add_file(report, *left);
  axis.found = take_model(*found);
  axis.left = take_model(*left);
  add_trained_range(report, label, report::Stage::as_found, axis.found);
  add_trained_range(report, label, report::Stage::as_left, axis.left);
  if (axis.left && find_other_gyro(*axis.left, axis.runs.front().dataset.identity) != nullptr)
    report.missing.push_back("models: one trained on this unit");
  if (axis.left)
    if (auto added = add_experiment(report, experiment_folder(options, choice), label, *axis.left); !added)
      return added;
  return add_results(report, axis);
}

/// Reports the bias reference only once if it is equal for all axes and runs.
void merge_bias_references(report::CalibrationReport& report) {
  const auto differs = [&](const report::BiasReference& one) { return one.zero != report.bias_zeros.front().zero; };
  if (report.bias_zeros.empty() || std::ranges::any_of(report.bias_zeros, differs)) return;
  report.bias_zero = report.bias_zeros.front().zero;
  report.bias_zeros.clear();
}

/// Returns the last `count` parts of a path.
std::string path_end(const std::filesystem::path& path, std::ptrdiff_t count) {
  std::filesystem::path end;
  const std::vector<std::filesystem::path> parts(path.begin(), path.end());
  for (auto part = parts.end() - std::min(count, std::ssize(parts)); part != parts.end(); ++part) end /= *part;
  return end.string();
}

/// Returns the name of each record in the report: its file name, and before it as many folders as distinguish the
/// records.
std::vector<std::string> name_records(const std::vector<CheckedRecord>& records) {
  constexpr std::ptrdiff_t kMostParts = 64;
  std::vector<std::filesystem::path> paths;
  for (const CheckedRecord& one : records)
    paths.push_back(std::filesystem::absolute(one.files.path).lexically_normal());
  std::vector<std::string> names;
  for (std::ptrdiff_t count = 1; count <= kMostParts; ++count) {
    names.clear();
    for (const auto& path : paths) names.push_back(path_end(path, count));
    if (std::set(names.begin(), names.end()).size() == std::set(paths.begin(), paths.end()).size()) break;
  }
  return names;
}

/// Sorts the deviations of all records by their time; those of an unknown time are last.
void sort_by_time(std::vector<report::Deviation>& deviations) {
  std::ranges::stable_sort(deviations, {},
                           [](const report::Deviation& one) { return std::pair(one.utc.empty(), one.utc); });
}

Result<report::CalibrationReport> build_report(const ReportInput& given, const std::string& unit,
                                               const CalibrationArguments& options) {
  const auto records = read_records(given.records, unit);
  if (!records) return failure(records.error());
  report::CalibrationReport report{.program_version = GYROTHERM_VERSION};
  const std::vector<std::string> names = name_records(given.records);
  for (std::size_t i = 0; i < records->size(); ++i) {
    const CheckedRecord& one = given.records[i];
    add_record(report, {(*records)[i], names[i], one.sha256, one.chain_verified, one.parts}, unit);
  }
  sort_by_time(report.deviations);
  const record::UnitInfo& info = *find_unit(given.records.front().info, unit);
  for (std::size_t a = 0; a < info.axes.size(); ++a) {
    const data::AxisChoice choice{unit, info.axes[a].name};
    if (auto added = add_axis(report, given, *records, choice, record::axis_label(info, a), options); !added)
      return failure(added.error());
  }
  merge_bias_references(report);
  std::size_t units = 0;
  for (const CheckedRecord& one : given.records) units = std::max(units, one.info.units.size());
  add_order(report, given.laboratory, given.order, units);
  return report;
}

Result<void> check_units(const report::OrderFile& order, const std::vector<record::UnitInfo>& units,
                         const std::string& from) {
  std::vector<report::CalibratedItem> items;
  for (const record::UnitInfo& unit : units)
    items.push_back({.name = unit.name, .model = unit.model, .serial_number = unit.serial_number});
  return report::check_units(order, items, from);
}

/// Checks that the order matches the units of all records, before the first report is made.
Result<void> check_order(const ReportInput& given, const std::vector<std::string>& units) {
  if (!given.order) return {};
  for (const CheckedRecord& one : given.records) {
    std::vector<record::UnitInfo> reported;
    for (const std::string& unit : units) reported.push_back(*find_unit(one.info, unit));
    if (auto same = check_units(*given.order, reported, one.files.path); !same) return same;
  }
  return {};
}

/// Fails with usage if the folder has a report that is not a draft: an authorised report is never overwritten.
Result<void> check_is_free(const std::string& folder) {
  if (!std::filesystem::exists(folder + "/" + report::kCalibrationFile)) return {};
  const auto existing = load_calibration(folder);
  if (existing && existing->report.state == report::ReportState::draft) return {};
  return failure(FaultKind::usage, folder,
                 existing ? fmt::format("has a report that is {}; name another folder", name(existing->report.state))
                          : "has a calibration.json that is not a report; name another folder");
}

/// Returns what the report must state about the check runs of the rigs; empty if all are in control or explained.
Result<std::vector<std::string>> find_open_checks(const std::vector<CheckedRecord>& records, const std::string& named) {
  std::map<std::string, std::vector<std::string>> runs;  // start of each run, by the history of its rig
  for (const CheckedRecord& one : records) {
    const auto path = named.empty() ? find_history(one.info) : std::optional(named);
    if (path) runs[*path].push_back(civil_time(one.info.started_utc));
  }
  std::vector<std::string> open;
  for (const auto& [path, started_utc] : runs) {
    const auto text = read_text_file(path, kLargestTable);
    if (!text) return failure(text.error());
    const auto history = assurance::parse_history(*text, path);
    if (!history) return failure(history.error());
    if (auto one = describe_open_check(*history, started_utc)) open.push_back(std::move(*one));
  }
  return open;
}

/// Writes a draft and, last, its sources.json: an interrupted draft cannot be authorised.
Result<void> write_draft(Console& console, const report::CalibrationReport& report, const std::string& folder,
                         const CalibrationArguments& options) {
  const std::string path = folder + "/" + report::kSourcesFile;
  std::error_code error;
  std::filesystem::remove(path, error);
  if (auto written = write_calibration(console, report, folder, options.languages); !written) return written;
  const report::DraftSources sources = name_sources(options, folder, report.item.name, sha256(to_json(report)));
  return replace_text_file(path, to_json(sources));
}

}  // namespace

Result<report::CalibrationReport> make_calibration(Console& console, const CalibrationArguments& options,
                                                   const std::string& unit) {
  const auto given = load_all(console, options);
  if (!given) return failure(given.error());
  for (const CheckedRecord& one : given->records)
    if (find_unit(one.info, unit) == nullptr)
      return failure(FaultKind::bad_file, one.files.path, fmt::format("has no unit \"{}\"", unit));
  if (auto ordered = check_order(*given, {unit}); !ordered) return failure(ordered.error());
  const auto open_checks = find_open_checks(given->records, options.check_standard);
  if (!open_checks) return failure(open_checks.error());
  auto report = build_report(*given, unit, options);
  if (report) report->missing.insert(report->missing.end(), open_checks->begin(), open_checks->end());
  return report;
}

void add_report_texts(CLI::App& command, CalibrationArguments& options) {
  command.add_option("--laboratory", options.laboratory, "laboratory.toml: the laboratory's data for each report")
      ->type_name(value::kToml);
  command.add_option("--order", options.order, "order.toml: customer, unit, people, limits")->type_name(value::kToml);
}

Result<void> check_report_texts(const CalibrationArguments& options, const std::vector<record::UnitInfo>& units,
                                const std::string& from) {
  if (auto laboratory = parse_if_given(options.laboratory, report::parse_laboratory); !laboratory)
    return failure(laboratory.error());
  const auto order = parse_if_given(options.order, report::parse_order);
  if (!order) return failure(order.error());
  return *order ? check_units(**order, units, from) : Result<void>{};
}

Result<Exit> calibrate(Console& console, const CalibrationArguments& options) {
  const auto given = load_all(console, options);
  if (!given) return failure(given.error());
  const auto units = units_to_report(given->records, options.unit);
  if (!units) return failure(units.error());
  if (auto ordered = check_order(*given, *units); !ordered) return failure(ordered.error());
  for (const ModelSource* source : {&given->found, &given->left})
    if (auto apply = check_models_apply(given->records, *units, *source); !apply) return failure(apply.error());
  const auto report_folder = [&](const std::string& unit) {
    return units->size() > 1 ? options.out + "/" + unit : options.out;
  };
  for (const std::string& unit : *units)
    if (auto free = check_is_free(report_folder(unit)); !free) return failure(free.error());
  const auto open_checks = find_open_checks(given->records, options.check_standard);
  if (!open_checks) return failure(open_checks.error());
  const auto begin = [&](std::size_t unit) {
    return std::async(std::launch::async, [&, unit] {
      block_signals();
      return build_report(*given, (*units)[unit], options);
    });
  };
  // The next unit's report is made while the previous one is written.
  auto next = begin(0);
  for (std::size_t i = 0; i < units->size(); ++i) {
    auto report = next.get();
    if (i + 1 < units->size()) next = begin(i + 1);
    if (!report) return failure(report.error());
    report->missing.insert(report->missing.end(), open_checks->begin(), open_checks->end());
    const std::string folder = report_folder((*units)[i]);
    if (auto written = write_draft(console, *report, folder, options); !written) return failure(written.error());
    if (const auto wrong = report::find_wrong_days(*report); report->simulated && !wrong.empty())
      console.print_message(fmt::format("SIMULATED, therefore accepted: {}", fmt::join(wrong, "; ")));
    if (!report->missing.empty())
      console.print_message(fmt::format("draft; missing: {}", fmt::join(report->missing, "; ")));
  }
  return Exit::done;
}

}  // namespace gyrotherm::app
