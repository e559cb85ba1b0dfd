// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>
#include <variant>

#include "analysis/data/hold_noise.hpp"
#include "analysis/methods/method.hpp"
#include "report/report.hpp"

namespace gyrotherm::report {
namespace {

template <class Vector>
std::vector<double> to_vector(const Vector& values) {
  return {values.begin(), values.end()};
}

std::vector<std::vector<double>> matrix_rows(const Eigen::MatrixXd& matrix) {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) rows.push_back(to_vector(matrix.row(k)));
  return rows;
}

std::vector<std::string> term_texts(const std::vector<data::Term>& terms) {
  std::vector<std::string> texts;
  for (const data::Term& term : terms) texts.push_back(to_string(term));
  return texts;
}

double positive_or_nan(double value) { return value > 0 ? value : kNotKnown; }

/// Applies `make` to each of the three models.
template <class Make>
auto apply_to_models(const model::PerModel<model::TrainedModel>& models, Make make) {
  return model::PerModel<decltype(make(models.three_point))>{make(models.three_point), make(models.multi_point),
                                                             make(models.multi_point_t)};
}

ReportedCorrelation make_correlation(const data::RecordedRun& rate, const model::Selection& selection) {
  const data::Correlation correlation = correlate(rate.clusters, rate.dataset.gradients);
  return {.names = correlation.names,
          .magnitude = matrix_rows(correlation.gradient.cwiseAbs()),
          .gradient = matrix_rows(correlation.gradient),
          .temperature = to_vector(correlation.temperature),
          .rate = to_vector(correlation.rate),
          .selected_pairs = term_texts(selection.terms),
          .threshold = selection.threshold,
          .rank = selection.rank,
          .fallback = selection.fallback,
          .statement = selection.statement};
}

ReportedResidual make_residual(const model::Verification& verification) {
  return {.all = verification.compensated,
          .ramps = verification.ramps,
          .holds = verification.holds,
          .corners = verification.corners,
          .to_truth = verification.to_truth,
          .outside = verification.outside,
          .effective_parameters = positive_or_nan(verification.effective_parameters),
          .expected_in_sample_std = verification.expected_in_sample_std,
          .streamed = verification.streamed};
}

/// Joins neighbouring clusters of the same cycle.
std::vector<ReportedCycle> find_cycles(const data::RecordedRun& run) {
  const data::Clusters& clusters = run.clusters;
  std::vector<ReportedCycle> cycles;
  int current = -1;
  for (Eigen::Index k = 0; k < clusters.cycle.size(); ++k) {
    const int cycle = clusters.cycle(k);
    const bool known = cycle >= 0 && cycle < static_cast<int>(run.dataset.cycles.size());
    if (known && cycle != current)
      cycles.push_back({run.dataset.cycles[static_cast<std::size_t>(cycle)], clusters.start_s(k), 0});
    if (known) cycles.back().end_s = clusters.start_s(k) + clusters.length_s;
    current = known ? cycle : -1;
  }
  return cycles;
}

using RunMember = model::Verification model::TrainedModel::*;

ReportedSeries make_series(const data::RecordedRun& run, const model::PerModel<model::TrainedModel>& models,
                           RunMember on) {
  const data::Clusters& clusters = run.clusters;
  ReportedSeries series{
      .time_s = to_vector(clusters.start_s),
      .set_point_c = to_vector(clusters.set_point_c),
      .raw = to_vector(clusters.bias_deg_per_h),
      .thermometers_c = {},
      .residual = apply_to_models(models, [&](const auto& m) { return to_vector((m.*on).residual_deg_per_h); }),
      .cycles = find_cycles(run)};
  for (std::size_t k = 0; k < clusters.thermometers.size(); ++k)
    if (data::is_temperature(clusters.thermometers[k]))
      series.thermometers_c.emplace_back(clusters.thermometers[k],
                                         to_vector(clusters.temperature_c.col(static_cast<Eigen::Index>(k))));
  return series;
}

ReportedNoise make_noise(const data::RecordedRun& run, const model::PerModel<model::TrainedModel>& models,
                         RunMember on) {
  const auto residual_after = [&](const model::TrainedModel& model) -> const Eigen::VectorXd& {
    return (model.*on).residual_deg_per_h;
  };
  return {.holds = measure_hold_noise(run.dataset),
          .compensated_holds =
              measure_compensated_hold_noise(run.dataset, run.clusters, residual_after(models.multi_point_t)),
          .raw = cluster_allan_curve(run.clusters.bias_deg_per_h, run.clusters),
          .compensated = apply_to_models(
              models, [&](const auto& m) { return cluster_allan_curve(residual_after(m), run.clusters); })};
}

/// Returns the clusters with a residual of each of the three models. Only on these are they comparable with each other
/// and with the raw bias.
std::vector<Eigen::Index> find_common_rows(const model::PerModel<model::TrainedModel>& models, RunMember on) {
  Eigen::VectorXd all = (models.three_point.*on).residual_deg_per_h;
  for_each_model(models, [&](const char*, const model::TrainedModel& model) { all += (model.*on).residual_deg_per_h; });
  return data::finite_rows(all);
}

/// Returns the figures of the raw bias on some of the clusters of a verification.
data::Figures raw_at(const model::Verification& of, const data::RecordedRun& run,
                     const std::vector<Eigen::Index>& rows) {
  const bool are_all = of.compensated.count == std::ssize(rows);
  return are_all ? of.raw : compute_figures(run.clusters.bias_deg_per_h(rows), run.clusters, rows);
}

/// Returns the figures of the compensated bias on some of the clusters of a verification.
data::Figures compensated_at(const model::Verification& of, const data::RecordedRun& run,
                             const std::vector<Eigen::Index>& rows) {
  const bool are_all = of.compensated.count == std::ssize(rows);
  return are_all ? of.compensated : compute_figures(of.residual_deg_per_h(rows), run.clusters, rows);
}

model::PerModel<ReportedGain> compute_gains(const data::RecordedRun& run, const data::Figures& raw,
                                            const model::PerModel<model::TrainedModel>& models, RunMember on,
                                            const std::vector<Eigen::Index>& rows) {
  const auto std_of = [&](const model::TrainedModel& model) { return compensated_at(model.*on, run, rows).std; };
  const double three = std_of(models.three_point);
  const auto gain_over_three_point = [&](const model::TrainedModel& model) -> ReportedGain {
    const data::Improvement gain = data::improvement(raw.std, three, std_of(model));
    return {gain.multi_point_from_original, gain.paper_ratio, gain.residual_reduction};
  };
  const double of_three = data::improvement(raw.std, three, three).three_point_from_original;
  return {{.from_original = of_three},
          gain_over_three_point(models.multi_point),
          gain_over_three_point(models.multi_point_t)};
}

ReportedRun make_run(const ReportSourceRun& source, const model::PerModel<model::TrainedModel>& models, RunMember on) {
  const data::RecordedRun& run = source.recorded;
  const model::Verification& verification = models.multi_point.*on;
  bool in_sample = false;
  for_each_model(models, [&](const char*, const model::TrainedModel& model) {
    in_sample = in_sample || (model.*on).trained_on_this;
    assert((model.*on).residual_deg_per_h.size() == run.clusters.bias_deg_per_h.size());
    assert((model.*on).segments.size() == verification.segments.size());
  });
  const std::vector<Eigen::Index> rows = find_common_rows(models, on);
  const data::Figures raw = raw_at(verification, run, rows);
  return {
      .in_sample = in_sample,
      .profile = run.dataset.profile_name,
      .run_id = run.dataset.run_id,
      .bias_zero = run.dataset.bias_zero,
      .record_sha256 = source.record_sha256,
      .record_file_sha256 = source.record_file_sha256,
      .profile_sha256 = source.profile_sha256,
      .floor = verification.floor,
      .clusters = static_cast<int>(run.clusters.start_s.size()),
      .dropped_rest = run.clusters.dropped_rest,
      .dropped_gaps = run.clusters.dropped_gaps,
      .gaps_s = run.dataset.gaps_s,
      .raw = raw,
      .residual = apply_to_models(models, [&](const model::TrainedModel& model) { return make_residual(model.*on); }),
      .gain = compute_gains(run, raw, models, on, rows),
      .noise = make_noise(run, models, on),
      .characterisation = model::characterise(run.dataset, run.clusters, (models.multi_point_t.*on).residual_deg_per_h),
      .series = make_series(run, models, on)};
}

ReportedModel make_reported_model(const model::TrainedModel& trained) {
  const model::Model& model = trained.model;
  const auto& svr = std::get<methods::SvrModel>(model.function);
  ReportedModel reported{.inputs = model.inputs,
                         .method = model.method,
                         .terms = term_texts(model.terms),
                         .rank = polynomial_rank(model.terms),
                         .stored_numbers = stored_numbers(model),
                         .effective_parameters = positive_or_nan(model.effective_parameters),
                         .residual_std_deg_per_h = model.residual_std_deg_per_h,
                         .trained_on = {},
                         .options = model.tuning_options,
                         .tuning = model.tuning,
                         .parameters = svr.parameters,
                         .epsilon_deg_per_h = svr.parameters.epsilon * model.target_std_deg_per_h,
                         .support_vectors = static_cast<int>(svr.support_vectors.rows()),
                         .certified_gap = svr.relative_gap,
                         .kkt_violation = svr.kkt_violation,
                         .folds = model.folds,
                         .uncertainty = model.uncertainty};
  for (const model::TrainingRecord& record : model.trained_on)
    reported.trained_on.push_back(
        {record.run_id, record.profile_name, record.simulated, record.clusters, record.block});
  return reported;
}

std::optional<ReportedUncertainty> combine_uncertainty(const model::Model& model) {
  if (!model.uncertainty) return std::nullopt;
  const model::CombinedUncertainty all = combined(model.uncertainty->budget.rows);
  double squares = 0;
  for (const model::Sensitivity& one : model.uncertainty->sensitivities) squares += one.rms * one.rms;
  return ReportedUncertainty{all.standard_deg_per_h, all.coverage_factor, all.expanded_deg_per_h, std::sqrt(squares)};
}

ReportedVerification make_verification(const model::Verification& verification) {
  return {verification.compensated, verification.to_truth, verification.coverage};
}

/// Returns the variation between the runs that were not used to train the model.
std::optional<model::RunScatter> compare_runs(const model::TrainedModel& trained) {
  std::vector<model::Verification> unseen = trained.later;
  unseen.push_back(trained.random);
  return compute_run_scatter(unseen);
}

ReportedMethod make_method(std::string name, const model::TrainedModel& trained) {
  const model::Model& model = trained.model;
  ReportedMethod row{.name = std::move(name),
                     .inputs = model.inputs,
                     .method = model.method,
                     .title = {},
                     .citation = {},
                     .in_sample = trained.rate.compensated,
                     .leave_cycle_out = model.leave_cycle_out,
                     .nested = model.nested_leave_cycle_out,
                     .random = make_verification(trained.random),
                     .later = {},
                     .between_runs = compare_runs(trained),
                     .uncertainty = combine_uncertainty(model),
                     .stored_numbers = stored_numbers(model),
                     .effective_parameters = positive_or_nan(model.effective_parameters)};
  std::ranges::transform(trained.later, std::back_inserter(row.later), make_verification);
  if (const auto method = methods::find_method(model.method)) {
    row.title = (*method)->title;
    row.citation = (*method)->citation;
  }
  return row;
}

std::vector<ReportedMethod> make_methods(const model::Qualification& qualification) {
  std::vector<ReportedMethod> rows;
  for_each_trained(qualification, [&](const std::string& name, const model::TrainedModel& trained) {
    rows.push_back(make_method(name, trained));
  });
  return rows;
}

/// Collects the later runs. The noise floor is the same for every model; the raw bias is that of the clusters with a
/// residual of the multi-point model.
std::vector<ReportedLaterRun> collect_later_runs(const ReportSource& source) {
  std::vector<ReportedLaterRun> all;
  const std::vector<model::Verification>& verified = source.qualification.models.multi_point.later;
  assert(verified.size() == source.later.size());
  for (std::size_t k = 0; k < verified.size(); ++k) {
    const data::Dataset& dataset = source.later[k].recorded.dataset;
    all.push_back({source.later[k].name, dataset.profile_name, dataset.run_id, source.later[k].record_sha256,
                   verified[k].floor, verified[k].raw});
  }
  return all;
}

void add_segments(std::vector<ReportedSegment>& all, const char* run,
                  const model::PerModel<model::TrainedModel>& models, RunMember on) {
  for (std::size_t k = 0; k < (models.multi_point.*on).segments.size(); ++k) {
    const model::SegmentFigures& segment = (models.multi_point.*on).segments[k];
    all.push_back({run, segment.segment, segment.name, segment.hold, segment.start_s, segment.duration_s,
                   segment.mean_temperature_c, segment.mean_bias_deg_per_h,
                   apply_to_models(models, [&](const auto& model) { return (model.*on).segments[k].residual; })});
  }
}

/// Returns each warning once, in the order of first occurrence.
std::vector<std::string> collect_warnings(const ReportSource& source) {
  std::vector<std::string> all;
  const auto add = [&](const std::string& about, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      const std::string whole = about.empty() ? text : about + ": " + text;
      if (std::ranges::find(all, whole) == all.end()) all.push_back(whole);
    }
  };
  const model::PerModel<model::TrainedModel>& models = source.qualification.models;
  add("", source.qualification.comparison.warnings);
  for (const data::RecordedRun* run : {&source.rate.recorded, &source.random.recorded})
    if (const auto& titles = run->dataset.unreleased; !titles.empty())
      add("", {fmt::format("UNRELEASED programs: {}", fmt::join(titles, ", "))});
  if (source.rate.recorded.dataset.three_point_stand_in)
    add("", {"three-point: the record names no shell thermometer; a stand-in is used"});
  for_each_model(models, [&](const char*, const model::TrainedModel& m) { add(m.model.inputs, m.model.warnings); });
  for (const auto& [run, on] :
       {std::pair{"ramp", &model::TrainedModel::rate}, {"random", &model::TrainedModel::random}})
    for_each_model(models, [&](const char*, const model::TrainedModel& m) {
      // The models were trained on the ramp run by design, and the report marks its results as in-sample.
      auto warnings = (m.*on).warnings;
      if (on == &model::TrainedModel::rate)
        std::erase_if(warnings, [](const std::string& warning) {
          return warning == model::kTrainedOnThisWarning || warning == model::kTrainedOnThisVirtualRunWarning;
        });
      add(m.model.inputs + " on the " + run + " run", warnings);
    });
  return all;
}

}  // namespace

Report make_report(const ReportSource& source) {
  const model::PerModel<model::TrainedModel>& models = source.qualification.models;
  const data::RecordedRun &rate = source.rate.recorded, &random = source.random.recorded;
  const model::Model& multi_point = models.multi_point.model;
  Report report{
      .rig = source.rig,
      .thermal = source.thermal,
      .quick = multi_point.quick,
      .accept = {},
      .cluster_length_s = rate.clusters.length_s,
      .correlation = make_correlation(rate, multi_point.selection),
      .rate = make_run(source.rate, models, &model::TrainedModel::rate),
      .random = make_run(source.random, models, &model::TrainedModel::random),
      .folds = multi_point.folds,
      .leave_cycle_out = apply_to_models(models, [](const auto& m) { return m.model.leave_cycle_out; }),
      .nested_leave_cycle_out = apply_to_models(models, [](const auto& m) { return m.model.nested_leave_cycle_out; }),
      .models = apply_to_models(models, make_reported_model),
      .later = collect_later_runs(source),
      .methods = make_methods(source.qualification),
      .recommendation = source.qualification.recommendation,
      .warnings = collect_warnings(source),
      .segments = {},
      .program_version = source.program_version,
      .seed = source.seed,
      .days_later = source.days_later};
  report.rig.is_virtual = report.rig.is_virtual || rate.dataset.simulated || random.dataset.simulated;
  add_segments(report.segments, "rate", models, &model::TrainedModel::rate);
  add_segments(report.segments, "random", models, &model::TrainedModel::random);
  return report;
}

}  // namespace gyrotherm::report
