// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/training.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "analysis/data/input_noise.hpp"
#include "analysis/data/outliers.hpp"
#include "analysis/model/making.hpp"
#include "analysis/model/temperature_checks.hpp"
#include "analysis/model/uncertainty.hpp"

namespace gyrotherm::model {
namespace {

/// Returns true if the uncertainty of a thermometer among the inputs is assumed, because the record does not state it.
bool has_assumed_thermometer(const Model& model) {
  return model.uncertainty && std::ranges::any_of(model.uncertainty->budget.rows, [](const BudgetRow& row) {
           return row.assumed && row.source == Source::thermometer_calibration;
         });
}

tl::unexpected<Fault> interrupted_fault() { return failure(FaultKind::interrupted, "training", "stopped on request"); }

/// Returns the scaled inputs of any clusters.
Result<data::SampleMatrix> scaled_inputs(const Preparation& preparation, const data::Clusters& clusters) {
  return evaluate(preparation.terms, clusters).map([&](const data::SampleMatrix& inputs) {
    return apply(preparation.scaling, inputs);
  });
}

/// Returns the bias relative to the target's training mean, in units of its training STD.
Eigen::VectorXd scaled_target(const Preparation& preparation, const data::Clusters& clusters) {
  return (clusters.bias_deg_per_h.array() - preparation.target_mean_deg_per_h) / preparation.target_std_deg_per_h;
}

/// Combines a preparation and a fit into a model. Does not set the members that describe the training.
Model assemble(const Preparation& preparation, methods::Fit fit) {
  Model model;
  model.function = std::move(fit.function);
  model.effective_parameters = fit.effective_parameters;
  model.particulars = std::move(fit.particulars);
  model.variance = std::move(fit.variance);
  model.terms = preparation.terms;
  model.scaling = preparation.scaling;
  model.target_mean_deg_per_h = preparation.target_mean_deg_per_h;
  model.target_std_deg_per_h = preparation.target_std_deg_per_h;
  model.selection = preparation.selection;
  return model;
}

/// Returns the clusters with the bias that the method learns from.
data::Clusters apply_bias_filter(const methods::Method& method, data::Clusters training) {
  if (method.filter != nullptr) training.bias_deg_per_h = method.filter(training);
  return training;
}

/// Returns the covariance of the scaled inputs that the thermometers' uncertainty causes; empty for a method that does
/// not use it.
Result<Eigen::MatrixXd> scaled_covariance(const Preparation& preparation, const data::Clusters& clusters,
                                          const EstimatorOptions& estimator) {
  if (!estimator.method.uses_uncertainty) return Eigen::MatrixXd{};
  return input_covariance(preparation.terms, clusters, estimator.options.thermometer_uncertainty_k)
      .map([&](const Eigen::MatrixXd& covariance) -> Eigen::MatrixXd {
        const auto per_std = preparation.scaling.std.cwiseInverse().asDiagonal();
        return per_std * covariance * per_std;
      });
}

Result<methods::Fold> make_fold(const FoldData& split, const EstimatorOptions& estimator) {
  auto train_x = scaled_inputs(split.preparation, split.training.clusters);
  if (!train_x) return failure(train_x.error());
  auto test_x = scaled_inputs(split.preparation, split.held_out);
  if (!test_x) return failure(test_x.error());
  auto covariance = scaled_covariance(split.preparation, split.training.clusters, estimator);
  if (!covariance) return failure(covariance.error());
  return methods::Fold{{.train_x = std::move(*train_x),
                        .train_y = scaled_target(split.preparation, split.training.clusters),
                        .test_x = std::move(*test_x),
                        .test_y = scaled_target(split.preparation, split.held_out),
                        .target_scale = split.preparation.target_std_deg_per_h,
                        .train_rows = split.training_rows},
                       split.preparation.terms,
                       std::move(*covariance)};
}

/// Chooses the method's hyper-parameters using only these splits.
Result<methods::Choice> choose(const std::vector<FoldData>& splits, const EstimatorOptions& estimator,
                               const ProgressSink& progress) {
  std::vector<methods::Fold> folds;
  for (const FoldData& split : splits) {
    auto fold = make_fold(split, estimator);
    if (!fold) return failure(fold.error());
    folds.push_back(std::move(*fold));
  }
  return estimator.method.choose(folds, estimator.options, progress);
}

Result<Model> fit(const Preparation& preparation, const data::Clusters& training, const EstimatorOptions& estimator) {
  const auto x = scaled_inputs(preparation, training);
  if (!x) return failure(x.error());
  const Eigen::VectorXd y = scaled_target(preparation, training);
  auto covariance = scaled_covariance(preparation, training, estimator);
  if (!covariance) return failure(covariance.error());
  const methods::FitInput set{*x, y, preparation.terms, std::move(*covariance)};
  return estimator.method.fit(set, estimator.parameters, estimator.options).map([&](methods::Fit&& fitted) {
    return assemble(preparation, std::move(fitted));
  });
}

/// Returns the bias less the prediction for the held-out clusters of a split.
Result<Eigen::VectorXd> held_out_residual(const FoldData& split, const EstimatorOptions& estimator) {
  const auto model = fit(split.preparation, split.training.clusters, estimator);
  if (!model) return failure(model.error());
  return predict(*model, split.held_out).map([&](const Eigen::VectorXd& predicted) -> Eigen::VectorXd {
    return split.held_out.bias_deg_per_h - predicted;
  });
}

Eigen::VectorXd unknown_residual(Eigen::Index rows) {
  return Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN());
}

/// Data that every fit of a training uses.
struct TrainingContext {
  /// Clusters with every input, by record.
  std::vector<data::Clusters> records;
  Eigen::Index omitted_clusters{};  ///< without a value of every input
  data::TrainingSet training_set;   ///< all records, concatenated
  /// Constant of the power-on of each cluster; see power_on_constants().
  Eigen::VectorXd constants;
  /// Clusters without the constants, after the filter of the method.
  data::Clusters learnt;
  InputPlan inputs;
  std::vector<FoldData> splits;
  Preparation all;

  [[nodiscard]] data::Clusters without_constants() const {
    data::Clusters clusters = training_set.clusters;
    clusters.bias_deg_per_h -= constants;
    return clusters;
  }
};

std::string requested_inputs(const TrainingOptions& options, const methods::Method& method) {
  return options.inputs.empty() ? std::string(method.inputs) : options.inputs;
}

/// Fails if the one-standard-error rule is chosen for a method without C, σ and ε. The rule can order only these
/// parameters by simplicity.
Result<void> check_choice(const TrainingOptions& options, const methods::Method& method) {
  if (options.tuning.choice == svm::ChoiceRule::best || method.tunes_svr) return {};
  return failure(FaultKind::usage, "--choose",
                 fmt::format("one-se chooses C, sigma and epsilon; {} has none of them", method.name));
}

/// Counts how often these rows are held out, over all folds.
Eigen::Index count_held_out(const data::FoldPlan& folds, Eigen::Index all, const std::vector<Eigen::Index>& rows) {
  std::vector<bool> is_counted(static_cast<std::size_t>(all));
  for (const Eigen::Index row : rows) is_counted[static_cast<std::size_t>(row)] = true;
  Eigen::Index count = 0;
  for (const data::Fold& fold : folds.folds)
    count += std::ranges::count_if(fold.held_out,
                                   [&](Eigen::Index row) { return is_counted[static_cast<std::size_t>(row)]; });
  return count;
}

/// Plans the folds of all clusters, then removes the clusters that lack an input.
Result<void> plan_training(TrainingContext& context, const std::vector<data::Clusters>& records,
                           const TrainingOptions& options) {
  auto clusters = concatenate(records);
  if (!clusters) return failure(clusters.error());
  auto folds = options.fold_plan ? Result<data::FoldPlan>(*options.fold_plan) : plan_folds(records, options.folds);
  if (!folds) return failure(folds.error());
  std::vector<Eigen::Index> rows;
  Eigen::Index first = 0;
  for (const data::Clusters& record : records) {
    const auto whole = rows_with_inputs(context.inputs, record);
    if (!whole) return failure(whole.error());
    for (const Eigen::Index row : *whole) rows.push_back(first + row);
    context.records.push_back(pick_clusters(record, *whole));
    first += record.start_s.size();
  }
  context.omitted_clusters = first - static_cast<Eigen::Index>(rows.size());
  if (rows.empty()) return failure(FaultKind::usage, "training", "no cluster has a value of every input");
  const Eigen::Index held_out = count_held_out(*folds, first, rows);
  context.training_set = data::restrict_rows({.clusters = std::move(*clusters), .folds = std::move(*folds)}, rows);
  Eigen::Index remaining = 0;
  for (const data::Fold& fold : context.training_set.folds.folds) remaining += std::ssize(fold.held_out);
  if (remaining == held_out) return {};
  return failure(
      FaultKind::usage, "--folds",
      fmt::format("{}: some clusters with all inputs are in a fold that leaves no training clusters; use --folds "
                  "blocks, which divides the clusters evenly",
                  context.training_set.folds.statement));
}

Result<TrainingContext> make_context(const std::vector<data::Dataset>& datasets,
                                     const std::vector<data::Clusters>& records, const TrainingOptions& options,
                                     const methods::Method& method, const ProgressSink& progress) {
  if (datasets.empty() || datasets.size() != records.size()) {
    return failure(FaultKind::usage, "training", "needs at least one record");
  }
  if (datasets.front().thermometers.empty()) return failure(no_thermometer_fault(datasets.front()));
  TrainingContext context;
  auto inputs = plan_inputs(requested_inputs(options, method), datasets.front(), options.select);
  if (!inputs) return failure(inputs.error());
  context.inputs = std::move(*inputs);
  context.inputs.power_ons = power_on_rule(datasets.front());
  TrainingOptions named = options;
  named.folds.programs = list_programs(datasets);
  if (const auto planned = plan_training(context, records, named); !planned) return failure(planned.error());
  std::vector<data::Term> terms = context.inputs.fixed;
  terms.insert(terms.end(), context.inputs.candidates.begin(), context.inputs.candidates.end());
  if (const auto varies = check_temperatures_vary(terms, datasets, context.records); !varies)
    return failure(varies.error());
  auto splits = split_at_folds(context.training_set, context.inputs, method, progress);
  if (!splits) return failure(splits.error());
  context.splits = std::move(*splits);
  auto constants = power_on_constants(context.training_set.clusters, context.inputs.power_ons);
  if (!constants) return failure(constants.error());
  context.constants = std::move(*constants);
  context.learnt = apply_bias_filter(method, context.without_constants());
  auto all = prepare(context.inputs, {.clusters = context.learnt, .folds = context.training_set.folds});
  if (!all) return failure(all.error());
  context.all = std::move(*all);
  return context;
}

/// Fits the final model. Requests a tight duality gap, but accepts a fit that reaches only the ordinary gap.
Result<Model> fit_final(const TrainingContext& context, EstimatorOptions estimator, const ProgressSink& progress) {
  constexpr double kTightGap = 1e-6;
  estimator.options.tight_gap = kTightGap;
  if (!should_continue(progress, "fitting", 0)) return interrupted_fault();
  auto model = fit(context.all, context.learnt, estimator);
  if (!should_continue(progress, "fitting", 1)) return interrupted_fault();
  return model;
}

/// Enlarges the variance of the coefficients of a linear function for correlated residuals.
void widen_for_correlation(Model& model) {
  if (!model.variance || !std::holds_alternative<methods::LinearModel>(model.function)) return;
  model.variance->posterior *= correlation_factor(model);
}

svm::TuningOptions make_tuning_options(const TrainingOptions& options) {
  svm::TuningOptions tuning = options.tuning;
  if (!options.quick) return tuning;
  constexpr int kQuickParticles = 8, kQuickIterations = 6;
  tuning.swarm.particles = kQuickParticles;
  tuning.swarm.iterations = kQuickIterations;
  return tuning;
}

void collect_warnings(Model& model, const TrainingContext& context, const std::vector<std::string>& choice_warnings,
                      const std::vector<data::Dataset>& datasets, const std::vector<data::Clusters>& records) {
  if (model.selection.fallback) model.warnings.push_back(model.selection.statement);
  if (context.omitted_clusters > 0) {
    model.warnings.push_back(
        fmt::format("clusters without all inputs (the first of a run has no rate) were excluded: {} of {}",
                    context.omitted_clusters, context.omitted_clusters + context.training_set.clusters.start_s.size()));
  }
  model.warnings.insert(model.warnings.end(), choice_warnings.begin(), choice_warnings.end());
  if (auto outlying = data::describe_outlying_clusters(context.training_set.clusters, model.leave_cycle_out_residual);
      !outlying.empty())
    model.warnings.push_back(std::move(outlying));
  if (auto scatter = describe_scatter(model.power_ons, context.inputs.power_ons.repeatability_deg_per_h);
      !scatter.empty())
    model.warnings.push_back(std::move(scatter));
  warn_about_over_fit(model, datasets, records);
  if (auto warning = make_no_gain_warning("held-out residual bias", *model.verdict))
    model.warnings.push_back(std::move(*warning));
  if (auto confusion = find_confusion_with_time(model.terms, context.records)) {
    if (model.verdict->gain == Gain::improves) {
      model.verdict->gain = Gain::undecided;
      model.verdict->statement += "; temperature and time cannot be told apart";
    }
    model.warnings.push_back(std::move(*confusion));
  }
}

/// The held-out residual for the budget, without the constants of the power-ons, which have a row of their own.
struct BudgetResidual {
  Eigen::VectorXd residual;
  /// True if the residual was also used to choose the hyper-parameters.
  bool chosen_on_these_folds{};
};

/// Evaluates the training procedure on held-out clusters, and by nested folds if requested. Returns the nested residual
/// if there is one, because it was not used to choose parameters.
Result<BudgetResidual> evaluate_held_out(Model& model, const TrainingContext& context,
                                         const EstimatorOptions& estimator, bool nested, const ProgressSink& progress) {
  const data::Clusters& clusters = context.training_set.clusters;
  auto residual = leave_out_residual(context.splits, clusters.start_s.size(), estimator, progress);
  if (!residual) return failure(residual.error());
  model.folds = context.training_set.folds.statement;
  model.leave_cycle_out = compute_figures(*residual, clusters);
  model.leave_cycle_out_residual = *residual;
  model.verdict = judge_held_out(*residual, clusters, model.effective_parameters);
  // If no parameters were chosen, the residual is independent of the held-out folds.
  if (estimator.parameters.empty()) {
    if (nested) model.nested_leave_cycle_out = model.leave_cycle_out;
    return BudgetResidual{*residual - context.constants, false};
  }
  if (!nested) return BudgetResidual{*residual - context.constants, true};
  auto unseen = nested_residual(context.training_set, context.splits, context.inputs, estimator, progress);
  if (!unseen) return failure(unseen.error());
  model.nested_leave_cycle_out = compute_figures(*unseen, clusters);
  model.verdict = judge_held_out(*unseen, clusters, model.effective_parameters);
  return BudgetResidual{*unseen - context.constants, false};
}

Result<Model> train_in_arena(const std::vector<data::Dataset>& datasets, const std::vector<data::Clusters>& clusters,
                             const TrainingOptions& options, const ProgressSink& progress) {
  const auto method = methods::find_method(options.method);
  if (!method) return failure(method.error());
  if (const auto sound = check_records(datasets, clusters); !sound) return failure(sound.error());
  if (const auto fits = check_choice(options, **method); !fits) return failure(fits.error());
  const auto context = make_context(datasets, clusters, options, **method, progress);
  if (!context) return failure(context.error());

  const svm::TuningOptions tuning_options = make_tuning_options(options);
  const ThermometersInUse thermometers = thermometers_in_use(datasets.front());
  EstimatorOptions estimator{**method,
                             {},
                             {.tuning = tuning_options,
                              .seed = tuning_options.swarm.seed,
                              .quick = options.quick,
                              .thermometer_uncertainty_k = thermometers.uncertainty_k}};
  auto choice = choose(context->splits, estimator, progress);
  if (!choice) return failure(choice.error());
  estimator.parameters = choice->parameters;
  auto model = fit_final(*context, estimator, progress);
  if (!model) return model;
  const auto budget_residual = evaluate_held_out(*model, *context, estimator, options.nested, progress);
  if (!budget_residual) return failure(budget_residual.error());
  model->residual_noise = held_out_noise(*model, datasets, context->records, context->training_set.clusters);
  model->program_version = options.program_version;
  model->method = (*method)->name;
  model->inputs = requested_inputs(options, **method);
  model->hyper_parameters = choice->parameters;
  model->cluster_length_s = context->training_set.clusters.length_s;
  if (choice->tuning) model->tuning = *choice->tuning;
  model->tuning_options = tuning_options;
  model->quick = options.quick;
  record_sources(*model, datasets, context->records);
  model->power_ons = list_power_ons(context->training_set.clusters, context->constants);
  if (const auto judged = evaluate_in_sample(*model, context->without_constants()); !judged)
    return failure(judged.error());
  widen_for_correlation(*model);
  auto uncertainty = evaluate_uncertainty(
      *model, {datasets, context->records, budget_residual->residual, budget_residual->chosen_on_these_folds});
  if (!uncertainty) return failure(uncertainty.error());
  model->uncertainty = std::move(*uncertainty);
  if ((*method)->uses_uncertainty && has_assumed_thermometer(*model))
    choice->warnings.push_back("the record contains no uncertainty of its thermometers: 0.05 K is assumed");
  collect_warnings(*model, *context, choice->warnings, datasets, clusters);
  return model;
}

}  // namespace

Result<Preparation> prepare(const InputPlan& plan, const data::TrainingSet& training) {
  auto chosen = choose_inputs(plan, training);
  if (!chosen) return failure(chosen.error());
  const auto inputs = evaluate(chosen->terms, training.clusters);
  if (!inputs) return failure(inputs.error());
  const auto scaling = fit_scaling(*inputs, chosen->terms);
  if (!scaling) return failure(scaling.error());
  const data::Figures target = data::compute_figures(training.clusters.bias_deg_per_h);
  constexpr double kRounding = 1e-12;
  if (!(target.std > kRounding * target.max_abs)) {
    return failure(FaultKind::usage, "training", "the bias does not vary over the training clusters");
  }
  return Preparation{std::move(chosen->terms), std::move(chosen->selection), *scaling, target.mean, target.std};
}

Result<std::vector<FoldData>> split_at_folds(const data::TrainingSet& training_set, const InputPlan& inputs,
                                             const methods::Method& method, const ProgressSink& progress) {
  std::vector<FoldData> splits;
  const std::size_t folds = training_set.folds.folds.size();
  for (std::size_t fold = 0; fold < folds; ++fold) {
    if (!should_continue(progress, "choosing inputs", static_cast<double>(fold) / static_cast<double>(folds))) {
      return interrupted_fault();
    }
    const data::Fold& rows = training_set.folds.folds[fold];
    data::TrainingSet training = restrict_rows(training_set, rows.training);
    auto without = without_power_on_constants(std::move(training.clusters), inputs.power_ons);
    if (!without) return failure(without.error());
    training.clusters = apply_bias_filter(method, std::move(*without));
    auto preparation = prepare(inputs, training);
    if (!preparation) {
      Fault fault = preparation.error();
      if (fault.kind == FaultKind::usage)
        fault.what += fmt::format(
            " (training without fold {} of {}, {}); choose other --folds, or remove the input from "
            "--inputs",
            fold + 1, folds, training_set.folds.statement);
      return failure(std::move(fault));
    }
    splits.push_back({.training = std::move(training),
                      .held_out = pick_clusters(training_set.clusters, rows.held_out),
                      .training_rows = rows.training,
                      .held_out_rows = rows.held_out,
                      .preparation = std::move(*preparation)});
  }
  if (!should_continue(progress, "choosing inputs", 1)) return interrupted_fault();
  return splits;
}

Result<Eigen::VectorXd> leave_out_residual(const std::vector<FoldData>& splits, Eigen::Index rows,
                                           const EstimatorOptions& estimator, const ProgressSink& progress) {
  Eigen::VectorXd residual = unknown_residual(rows);
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const double done = static_cast<double>(i) / static_cast<double>(splits.size());
    if (!should_continue(progress, "leaving each fold out", done)) return interrupted_fault();
    const auto held_out = held_out_residual(splits[i], estimator);
    if (!held_out) return failure(held_out.error());
    residual(splits[i].held_out_rows) = *held_out;
  }
  if (!should_continue(progress, "leaving each fold out", 1)) return interrupted_fault();
  return residual;
}

Result<Eigen::VectorXd> nested_residual(const data::TrainingSet& training_set, const std::vector<FoldData>& splits,
                                        const InputPlan& inputs, EstimatorOptions estimator,
                                        const ProgressSink& progress) {
  Eigen::VectorXd residual = unknown_residual(training_set.clusters.start_s.size());
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const std::string stage = fmt::format("nested, fold {} of {}", i + 1, splits.size());
    const ProgressSink at_begin = [&](std::string_view, double) { return should_continue(progress, stage, 0); };
    const ProgressSink within_stage = [&](std::string_view, double fraction) {
      return should_continue(progress, stage, fraction);
    };
    // The bias is not filtered here, since each inner split filters it.
    const auto inner = ensure_two_folds(restrict_rows(training_set, training_set.folds.folds[i].training));
    if (!inner) return failure(inner.error());
    const auto inner_splits = split_at_folds(*inner, inputs, estimator.method, at_begin);
    if (!inner_splits) return failure(inner_splits.error());
    const auto choice = choose(*inner_splits, estimator, within_stage);
    if (!choice) return failure(choice.error());
    estimator.parameters = choice->parameters;
    const auto held_out = held_out_residual(splits[i], estimator);
    if (!held_out) return failure(held_out.error());
    residual(splits[i].held_out_rows) = *held_out;
  }
  return residual;
}

Result<Model> train(const std::vector<data::Dataset>& datasets, const std::vector<data::Clusters>& clusters,
                    const TrainingOptions& options, const ProgressSink& progress) {
  const int threads = options.tuning.swarm.threads, available = oneapi::tbb::info::default_concurrency();
  oneapi::tbb::task_arena arena(threads == 0 ? available : std::min(threads, available));
  return arena.execute([&] { return train_in_arena(datasets, clusters, options, progress); });
}

}  // namespace gyrotherm::model
