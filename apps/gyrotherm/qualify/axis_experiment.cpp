// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/qualify/axis_experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "acquisition/record/csv.hpp"
#include "apps/gyrotherm/recorded_run.hpp"
#include "core/file.hpp"
#include "core/sha256.hpp"
#include "report/views.hpp"

namespace gyrotherm::app {
namespace {

/// Checks that the further and later runs differ from each other and from the two runs that the report quotes.
Result<void> check_apart(const AxisExperiment& experiment) {
  std::vector<data::RecordedRun> all = experiment.further;
  for (const ExperimentRun& run : experiment.later) all.push_back(run.recorded);
  return model::check_apart(experiment.rate.recorded.dataset, experiment.random.recorded.dataset, all);
}

Result<model::Qualification> train_all(const AxisExperiment& experiment, const AxisOptions& options,
                                       const ProgressSink& progress, std::vector<std::string>& warnings) {
  const auto& rate = experiment.rate.recorded;
  const auto& random = experiment.random.recorded;
  const auto begin_stage = [&](const std::string& stage) {
    if (options.on_stage) options.on_stage(stage);
  };
  begin_stage("train three models");
  auto models = train_models(rate, random, options.training, progress);
  if (!models) return failure(models.error());
  Result<void> written;
  for_each_model(*models, [&](const char*, const model::TrainedModel& trained) {
    if (!written) return;
    const model::Model& model = trained.model;
    written = write_model(fmt::format("{}/model-{}.json", options.folder, model.inputs), model);
  });
  if (!written) return failure(written.error());
  model::Qualification qualification{.models = std::move(*models), .comparison = {}};
  const auto on_comparison = [&](std::string_view method, std::string_view inputs) {
    begin_stage(fmt::format("{} {} on {}", options.compare ? "compare" : "train", method, inputs));
  };
  const auto scope = options.compare ? model::MethodScope::all : model::MethodScope::recommended;
  auto comparison = train_compared(rate, random, scope, options.training, on_comparison, progress);
  if (!comparison) return failure(comparison.error());
  warnings.insert(warnings.end(), comparison->warnings.begin(), comparison->warnings.end());
  qualification.comparison = std::move(*comparison);
  const auto on_choice = [&](std::string_view method, std::string_view inputs) {
    begin_stage(fmt::format("evaluate {} on {} with further records", method, inputs));
  };
  auto recommendation =
      recommend_trained(qualification, rate, experiment.further, options.training, on_choice, progress);
  if (!recommendation) return failure(recommendation.error());
  qualification.recommendation = std::move(*recommendation);
  for_each_trained(qualification, [&](const std::string& name, const model::TrainedModel& trained) {
    if (written && name == qualification.recommendation.recommended)
      written = write_model(options.folder + "/model-recommended.json", trained.model);
  });
  if (!written) return failure(written.error());
  return qualification;
}

std::size_t unit_index(const rig::RigFile& rig, const data::AxisChoice& of) {
  const auto found =
      std::ranges::find(rig.units, of.unit, [](const auto& unit) -> const std::string& { return unit.info.name; });
  return found == rig.units.end() ? 0 : static_cast<std::size_t>(found - rig.units.begin());
}

std::string describe_gyro(const rig::RigFile& rig, const data::AxisChoice& of) {
  const auto unit = unit_index(rig, of);
  const auto& info = rig.units[unit].info;
  const auto axis = std::ranges::find(info.axes, of.axis, &record::AxisInfo::name);
  const double scale = axis == info.axes.end() ? info.axes.front().scale : axis->scale;
  const auto& described = find_gyro_line(rig, unit).stream;
  const auto stream = described ? fmt::format("stream {} ({}), ", described->name, described->vendor) : std::string();
  const auto& model = rig.gyro_model;
  auto text = is_named(of) ? qualified_name(of) + ", " : std::string();
  if (!info.model.empty()) text += info.model + ", ";
  if (!info.serial_number.empty()) text += "serial number " + info.serial_number + ", ";
  text += fmt::format("{}{}, {:g} arcsec each", stream, stream.empty() ? "pulse counts" : "counts", scale);
  if (!model.name.empty()) text += fmt::format("; thermal model \"{}\", film \"{}\"", model.name, model.film);
  return text;
}

/// Returns the calibration and its standard uncertainty: "u = 0.02 K, calibrated 2025-12-25".
std::string describe_calibration_with_uncertainty(const record::Channel& channel) {
  auto text = record::describe_calibration(channel);
  const auto add = [&](const std::string& more) { text = text == "none" ? more : text + ", " + more; };
  if (const auto u = channel.uncertainty.calibration) add(fmt::format("u = {:g} K", u->value));
  if (const auto day = channel.uncertainty.calibrated) add("calibrated " + record::format_day(*day));
  return text;
}

report::ReportedRig describe_rig(const rig::RigFile& rig, const data::Dataset& dataset) {
  report::ReportedRig reported{.name = rig.name,
                               .title = rig.title,
                               .gyro = describe_gyro(rig, dataset.of),
                               .sha256 = sha256(rig.text),
                               .is_virtual = rig.simulated,
                               .gyro_model = rig.gyro_model.name,
                               .gyro_film = rig.gyro_model.film,
                               .gyro_model_sha256 = rig.gyro_model.text.empty() ? "" : sha256(rig.gyro_model.text),
                               .thermometers = {}};
  for (const auto& channel : list_channels(rig))
    if (std::ranges::count(dataset.thermometers, channel.name) > 0)
      reported.thermometers.push_back(
          {channel.name, channel.instrument, describe_calibration_with_uncertainty(channel)});
  return reported;
}

report::Report build_report(const rig::RigFile& rig, const AxisExperiment& experiment,
                            const model::Qualification& qualification, const AxisOptions& options) {
  const model::QualificationOptions& training = options.training;
  const auto& [rate, random, later, further] = experiment;
  std::vector<report::ReportSourceLater> after;
  for (const ExperimentRun& run : later)
    after.push_back({std::filesystem::path(run.stage).filename().string(), run.recorded, run.sha256});
  const auto source = [](const ExperimentRun& run) {
    return report::ReportSourceRun{run.recorded, run.sha256, sha256(run.profile.text), run.file_sha256};
  };
  report::Report report = report::make_report({.rig = describe_rig(rig, rate.recorded.dataset),
                                               .thermal = options.thermal,
                                               .rate = source(rate),
                                               .random = source(random),
                                               .later = std::move(after),
                                               .qualification = qualification,
                                               .program_version = training.program_version,
                                               .seed = training.seed,
                                               .days_later = random.days_later});
  std::vector<report::Limit> limits;
  for (const ExperimentRun* run : {&rate, &random})
    for (const profile::AcceptLimit& limit : run->profile.accept) limits.push_back({limit.key, limit.at_most});
  report.accept = compare_with_limits(report, limits);
  return report;
}

}  // namespace

Result<data::RecordedRun> extract_axis(const record::Record& record, const std::string& path,
                                       const data::AxisChoice& of) {
  auto dataset = data::make_dataset(record, path, of);
  return data::make_clusters(dataset).map([&](data::Clusters clusters) {
    return data::RecordedRun{std::move(dataset), std::move(clusters)};
  });
}

std::string digest_rows(const record::Record& record) {
  Sha256 sum;
  record::write_csv(record, [&](std::string_view piece) { sum.add(piece); });
  return hex(sum.digest());
}

Result<AxisOutcome> carry_out(AxisExperiment& experiment, const rig::RigFile& rig, const AxisOptions& options,
                              const ProgressSink& progress, std::vector<std::string>& warnings) {
  if (auto apart = check_apart(experiment); !apart) return failure(apart.error());
  auto trained = train_all(experiment, options, progress, warnings);
  if (!trained) return failure(trained.error());
  std::vector<data::RecordedRun> after;
  for (const ExperimentRun& run : experiment.later) after.push_back(run.recorded);
  if (!after.empty() && options.on_stage) options.on_stage("verify later");
  if (auto verified = verify_later(*trained, after); !verified) return failure(verified.error());
  if (options.on_stage) options.on_stage("report");
  auto report = build_report(rig, experiment, *trained, options);
  if (auto written = report::write_report(to_json(report), options.folder + "/report"); !written)
    return failure(written.error());
  return AxisOutcome{std::move(*trained), std::move(report)};
}

}  // namespace gyrotherm::app
