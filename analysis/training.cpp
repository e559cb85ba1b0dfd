#include "analysis/training.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "analysis/fitting.hpp"
#include "analysis/folds.hpp"
#include "analysis/inputs.hpp"
#include "analysis/method.hpp"

namespace gyrotherm {
namespace {

/// Clusters of one fold: what is learnt from, what is held out, and what was learnt before the fit.
struct Split {
  Clusters training;
  Clusters held_out;
  std::vector<Eigen::Index> held_out_rows;
  Preparation preparation;
};

/// Everything the fits share.
struct Workshop {
  Clusters clusters;
  Clusters lesson;  ///< the clusters as the method learns from them
  InputPlan inputs;
  FoldPlan folds;
  std::vector<Split> splits;
  Preparation all;
};

/// A method with all that its fits need.
struct Recipe {
  const Method& method;
  HyperParameters parameters;
  MethodOptions options;
};

tl::unexpected<Fault> stopped() { return failure(FaultKind::interrupted, "training", "stopped on request"); }

/// What a method learns from: its filter has smoothed the bias, if it has one.
Clusters lesson_of(const Method& method, Clusters training) {
  if (method.filter != nullptr) training.bias_deg_per_h = method.filter(training);
  return training;
}

Result<Split> split_at(const Workshop& shop, const Method& method, int fold) {
  Split split;
  split.training = lesson_of(method, pick(shop.clusters, rows_outside(shop.folds, fold)));
  split.held_out_rows = rows_in(shop.folds, fold);
  split.held_out = pick(shop.clusters, split.held_out_rows);
  auto preparation = prepare(shop.inputs, split.training);
  if (!preparation) return failure(preparation.error());
  split.preparation = std::move(*preparation);
  return split;
}

std::string inputs_of(const TrainingOptions& options, const Method& method) {
  return options.inputs.empty() ? std::string(method.inputs) : options.inputs;
}

Result<Workshop> set_up(const std::vector<Dataset>& datasets, const std::vector<Clusters>& records,
                        const TrainingOptions& options, const Method& method) {
  if (datasets.empty() || datasets.size() != records.size()) {
    return failure(FaultKind::usage, "training", "needs at least one record");
  }
  auto clusters = concatenate(records);
  if (!clusters) return failure(clusters.error());
  auto inputs = plan_inputs(inputs_of(options, method), datasets.front(), options.threshold);
  if (!inputs) return failure(inputs.error());
  auto folds = plan_folds(records);
  if (!folds) return failure(folds.error());
  Workshop shop;
  shop.clusters = std::move(*clusters);
  shop.inputs = std::move(*inputs);
  shop.folds = std::move(*folds);
  for (int fold = 0; fold < shop.folds.count; ++fold) {
    auto split = split_at(shop, method, fold);
    if (!split) return failure(split.error());
    shop.splits.push_back(std::move(*split));
  }
  shop.lesson = lesson_of(method, shop.clusters);
  auto all = prepare(shop.inputs, shop.lesson);
  if (!all) return failure(all.error());
  shop.all = std::move(*all);
  return shop;
}

Result<Fold> fold_of(const Split& split) {
  auto train_x = scaled_inputs(split.preparation, split.training);
  if (!train_x) return failure(train_x.error());
  auto test_x = scaled_inputs(split.preparation, split.held_out);
  if (!test_x) return failure(test_x.error());
  return Fold{.train_x = std::move(*train_x),
              .train_y = scaled_target(split.preparation, split.training),
              .test_x = std::move(*test_x),
              .test_y = scaled_target(split.preparation, split.held_out),
              .target_scale = split.preparation.target_std_deg_per_h,
              .terms = split.preparation.terms};
}

Result<Choice> choose(const Workshop& shop, const Recipe& recipe, const ProgressSink& progress) {
  std::vector<Fold> folds;
  for (const Split& split : shop.splits) {
    auto fold = fold_of(split);
    if (!fold) return failure(fold.error());
    folds.push_back(std::move(*fold));
  }
  return recipe.method.choose(folds, recipe.options, progress);
}

Result<Model> fit(const Preparation& preparation, const Clusters& training, const Recipe& recipe) {
  const auto x = scaled_inputs(preparation, training);
  if (!x) return failure(x.error());
  const Eigen::VectorXd y = scaled_target(preparation, training);
  return recipe.method.fit({*x, y, preparation.terms}, recipe.parameters, recipe.options).map([&](Fit&& fitted) {
    return assemble(preparation, std::move(fitted));
  });
}

/// The model to keep asks for a tight certificate and settles for the common one.
Result<Model> fit_to_keep(const Workshop& shop, Recipe recipe) {
  constexpr double kTightGap = 1e-6;
  recipe.options.tight_gap = kTightGap;
  return fit(shop.all, shop.lesson, recipe);
}

Result<Eigen::VectorXd> leave_out_residual(const Workshop& shop, const Recipe& recipe, const ProgressSink& progress) {
  Eigen::VectorXd residual(shop.clusters.bias_deg_per_h.size());
  for (std::size_t i = 0; i < shop.splits.size(); ++i) {
    const Split& split = shop.splits[i];
    if (!keep_going(progress, "leaving each fold out", static_cast<double>(i) / shop.folds.count)) return stopped();
    const auto model = fit(split.preparation, split.training, recipe);
    if (!model) return failure(model.error());
    const auto predicted = predict(*model, split.held_out);
    if (!predicted) return failure(predicted.error());
    residual(split.held_out_rows) = split.held_out.bias_deg_per_h - *predicted;
  }
  return residual;
}

TuningOptions tuning_options_of(const TrainingOptions& options) {
  TuningOptions tuning = options.tuning;
  if (!options.quick) return tuning;
  constexpr int kQuickParticles = 8, kQuickIterations = 6;
  tuning.swarm.particles = kQuickParticles;
  tuning.swarm.iterations = kQuickIterations;
  return tuning;
}

void record_sources(Model& model, const std::vector<Dataset>& datasets, const std::vector<Clusters>& records) {
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const Dataset& dataset = datasets[i];
    model.trained_on.push_back({dataset.run_id, dataset.path, dataset.profile_name, dataset.simulated,
                                static_cast<int>(records[i].start_s.size()), records[i].start_s(0),
                                records[i].start_s(records[i].start_s.size() - 1) + records[i].length_s});
    if (dataset.three_point_stand_in && model.inputs == "three-point") {
      model.warnings.push_back(
          fmt::format("{}: no shell thermometer; {} stands in", dataset.path, dataset.three_point.back()));
    }
  }
}

/// What the fit does on its own training clusters, and the range in which it was made.
Result<void> judge_in_sample(Model& model, const Workshop& shop) {
  const auto inputs = evaluate(model.terms, shop.clusters);
  if (!inputs) return failure(inputs.error());
  model.input_min = inputs->colwise().minCoeff();
  model.input_max = inputs->colwise().maxCoeff();
  const Eigen::VectorXd residual = shop.clusters.bias_deg_per_h - predict(model, *inputs);
  model.in_sample = figures_of(residual);
  const double freedom = static_cast<double>(residual.size()) - model.effective_parameters;
  model.residual_std_deg_per_h = freedom > 0 ? std::sqrt(residual.squaredNorm() / freedom) : std::nan("");
  return {};
}

void collect_warnings(Model& model, const std::vector<std::string>& of_choice, const std::vector<Dataset>& datasets,
                      const std::vector<Clusters>& records) {
  if (model.selection.fallback) model.warnings.push_back(model.selection.statement);
  model.warnings.insert(model.warnings.end(), of_choice.begin(), of_choice.end());
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const NoiseFloor floor = noise_floor(records[i], datasets[i].segments);
    if (!(model.in_sample.std < floor.deg_per_h)) continue;
    model.warnings.push_back(
        fmt::format("over-fit: the in-sample STD, {:.4g} °/h, is below the noise floor of {}, {:.4g} °/h",
                    model.in_sample.std, std::filesystem::path(datasets[i].path).filename().string(), floor.deg_per_h));
  }
}

/// A run given twice would be held out and learnt from at once.
Result<void> check_distinct(const std::vector<Dataset>& datasets) {
  for (std::size_t i = 0; i < datasets.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (datasets[i].run_id == datasets[j].run_id)
        return failure(FaultKind::usage, datasets[i].path, fmt::format("is the same run as {}", datasets[j].path));
  return {};
}

}  // namespace

Result<Model> train(const std::vector<Dataset>& datasets, const std::vector<Clusters>& clusters,
                    const TrainingOptions& options, const ProgressSink& progress) {
  const auto method = find_method(options.method);
  if (!method) return failure(method.error());
  if (const auto distinct = check_distinct(datasets); !distinct) return failure(distinct.error());
  const auto shop = set_up(datasets, clusters, options, **method);
  if (!shop) return failure(shop.error());

  const TuningOptions tuning_options = tuning_options_of(options);
  Recipe recipe{**method, {}, {.tuning = tuning_options, .seed = tuning_options.swarm.seed}};
  auto choice = choose(*shop, recipe, progress);
  if (!choice) return failure(choice.error());
  recipe.parameters = choice->parameters;
  auto residual = leave_out_residual(*shop, recipe, progress);
  if (!residual) return failure(residual.error());
  if (!keep_going(progress, "fitting", 0)) return stopped();
  auto model = fit_to_keep(*shop, recipe);
  if (!model) return model;

  model->program_version = options.program_version;
  model->method = (*method)->name;
  model->inputs = inputs_of(options, **method);
  model->hyper_parameters = choice->parameters;
  model->cluster_length_s = shop->clusters.length_s;
  if (choice->tuning) model->tuning = *choice->tuning;
  model->tuning_options = tuning_options;
  model->quick = options.quick;
  model->folds = shop->folds.statement;
  model->leave_cycle_out = figures_of(*residual);
  model->leave_cycle_out_residual = std::move(*residual);
  record_sources(*model, datasets, clusters);
  if (const auto judged = judge_in_sample(*model, *shop); !judged) return failure(judged.error());
  collect_warnings(*model, choice->warnings, datasets, clusters);
  return model;
}

}  // namespace gyrotherm
