#include "app/commands/qualify_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acquisition/record/run_info.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "core/sha256.hpp"
#include "core/text.hpp"
#include "report/report_json.hpp"

namespace gyrotherm {
namespace {

ReportedRun reported(const QualificationRun& run, const std::vector<TrainedModel>& models,
                     Verification TrainedModel::*on) {
  return {.dataset = run.recorded.dataset,
          .clusters = run.recorded.clusters,
          .three_point = models[0].*on,
          .multi_point = models[1].*on,
          .multi_point_t = models[2].*on,
          .record_sha256 = run.sha256,
          .profile_sha256 = sha256(run.profile.text),
          .noise = noise_of_holds(run.recorded.dataset),
          .compensated_noise = noise_of_compensated_holds(run.recorded.dataset, run.recorded.clusters,
                                                          (models[2].*on).residual_deg_per_h)};
}

std::vector<ReportedThermometer> thermometers_of(const RigFile& rig) {
  std::vector<ReportedThermometer> all;
  for (const auto& channel : channels_of(rig))
    all.push_back({channel.name, channel.instrument, calibration_in_words(channel)});
  return all;
}

std::string gyro_in_words(const RigFile& rig) {
  const auto& model = rig.gyro_model;
  const auto stream =
      rig.gyro.stream ? fmt::format("stream {} ({}), ", rig.gyro.stream->name, rig.gyro.stream->vendor) : std::string();
  return fmt::format("{}{}, {:g} arcsec each", stream, stream.empty() ? "pulse counts" : "counts",
                     rig.gyro.info.scale) +
         (model.name.empty() ? "" : fmt::format("; thermal model \"{}\", film \"{}\"", model.name, model.film));
}

ComparedMethod compared(const TrainedModel& trained) {
  const auto& model = trained.model;
  return compared_method(fmt::format("{}-{}", model.method, model.inputs), model, trained.rate.compensated,
                         trained.random.compensated);
}

/// Every figure that a limit can be set on.
std::vector<std::string> known_figures() {
  std::vector<std::string> known{"noise_floor_deg_per_h", "rate.noise_floor_deg_per_h", "random.noise_floor_deg_per_h"};
  for (const auto* run : {"rate", "random", "rate_leave_cycle_out"})
    for (const auto* model : {"raw", "three_point", "multi_point", "multi_point_t"})
      for (const auto* figure : {"std", "mean", "rmse", "max_abs"})
        if (run != std::string_view("rate_leave_cycle_out") || model != std::string_view("raw"))
          known.push_back(fmt::format("{}.{}.{}_deg_per_h", run, model, figure));
  return known;
}

/// "random.raw.std_deg_per_h" → the number at /random/raw/std_deg_per_h.
double figure(const nlohmann::json& report, std::string path) {
  std::replace(path.begin(), path.end(), '.', '/');
  return report.at(nlohmann::json::json_pointer("/" + path)).get<double>();
}

/// The figures that the profiles' [accept] tables name, held against their limits.
std::vector<AcceptedLimit> judge_limits(const std::string& report_text, const Qualification& all) {
  const auto report = nlohmann::json::parse(report_text);
  std::vector<AcceptedLimit> verdicts;
  for (const auto* run : {&all.rate, &all.random})
    for (const auto& [key, at_most] : run->profile.accept) {
      const double value = figure(report, key);
      verdicts.push_back({.figure = key, .limit = at_most, .value = value, .passed = value <= at_most});
    }
  return verdicts;
}

}  // namespace

Result<void> check_accept(const Profile& profile, const std::string& file) {
  const auto known = known_figures();
  for (const auto& limit : profile.accept) {
    if (std::find(known.begin(), known.end(), limit.key) != known.end()) continue;
    const auto near = nearest(limit.key, known);
    return failure(FaultKind::bad_file, file,
                   fmt::format("[accept] names \"{}\", which is no figure of the report{}", limit.key,
                               near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  }
  return {};
}

AssembledReport assemble_report(const Qualification& all) {
  const auto correlation = correlate(all.rate.recorded.clusters, all.rate.recorded.dataset.gradients);
  const auto& model = all.rig.gyro_model;
  ReportInput input{.rig = {.name = all.rig.name,
                            .title = all.rig.title,
                            .gyro = gyro_in_words(all.rig),
                            .sha256 = sha256(all.rig.text),
                            .is_virtual = all.rig.simulated,
                            .gyro_model = model.name,
                            .gyro_film = model.film,
                            .gyro_model_sha256 = model.text.empty() ? "" : sha256(model.text),
                            .thermometers = thermometers_of(all.rig)},
                    .rate = reported(all.rate, all.models, &TrainedModel::rate),
                    .random = reported(all.random, all.models, &TrainedModel::random),
                    .models = {all.models[0].model, all.models[1].model, all.models[2].model},
                    .correlation = correlation,
                    .compared = {},
                    .accept = {},
                    .program_version = GYROTHERM_VERSION,
                    .seed = all.seed,
                    .warnings = all.warnings};
  std::transform(all.compared.begin(), all.compared.end(), std::back_inserter(input.compared), compared);
  input.accept = judge_limits(report_json(input), all);
  AssembledReport report{.json = report_json(input), .missed = {}};
  for (const auto& verdict : input.accept)
    if (!verdict.passed)
      report.missed.push_back(fmt::format("{} is {:.5g}, limit {:.5g}", verdict.figure, verdict.value, verdict.limit));
  return report;
}

std::string result_table(const Qualification& all) {
  const auto row = [](std::string_view what, const std::string& rate, const std::string& cycle,
                      const std::string& random, const std::string& size, const std::string& training) {
    return fmt::format("{:<39} {:>13} {:>14} {:>15} {:>7} {:>11}\n", what, rate, cycle, random, size, training);
  };
  const auto number = [](double std) { return fmt::format("{:.5f}", std); };
  const auto floor = [&](const QualificationRun& run) {
    return number(noise_floor(run.recorded.clusters, run.recorded.dataset.segments).deg_per_h);
  };
  const auto trained = [&](const TrainedModel& row_of) {
    const Model& model = row_of.model;
    return row(fmt::format("{:<13} {}", model.method, model.inputs), number(row_of.rate.compensated.std),
               number(model.leave_cycle_out.std), number(row_of.random.compensated.std),
               fmt::format("{}", stored_numbers(model)), fmt::format("{:.1f}", row_of.training_s));
  };
  auto text = std::string(all.rig.simulated ? "SIMULATED\n" : "");
  text += row("STD, °/h", "rate (fitted)", "held-out cycle", "random (unseen)", "numbers", "training, s");
  text += row("raw", number(all.models[0].rate.raw.std), "", number(all.models[0].random.raw.std), "", "");
  for (const TrainedModel& model : all.models) text += trained(model);
  for (const TrainedModel& model : all.compared) text += trained(model);
  return text + row("noise floor", floor(all.rate), "", floor(all.random), "", "");
}

}  // namespace gyrotherm
