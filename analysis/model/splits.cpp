#include "analysis/model/splits.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

namespace gyrotherm {
namespace {

tl::unexpected<Fault> stopped() { return failure(FaultKind::interrupted, "training", "stopped on request"); }

Result<Fold> fold_of(const FoldData& split) {
  auto train_x = scaled_inputs(split.preparation, split.training.clusters);
  if (!train_x) return failure(train_x.error());
  auto test_x = scaled_inputs(split.preparation, split.held_out);
  if (!test_x) return failure(test_x.error());
  return Fold{{.train_x = std::move(*train_x),
               .train_y = scaled_target(split.preparation, split.training.clusters),
               .test_x = std::move(*test_x),
               .test_y = scaled_target(split.preparation, split.held_out),
               .target_scale = split.preparation.target_std_deg_per_h},
              split.preparation.terms};
}

/// Bias less prediction of what the split holds out.
Result<Eigen::VectorXd> residual_of(const FoldData& split, const EstimatorOptions& estimator) {
  const auto model = fit(split.preparation, split.training.clusters, estimator);
  if (!model) return failure(model.error());
  return predict(*model, split.held_out).map([&](const Eigen::VectorXd& predicted) -> Eigen::VectorXd {
    return split.held_out.bias_deg_per_h - predicted;
  });
}

Eigen::VectorXd unknown(Eigen::Index rows) {
  return Eigen::VectorXd::Constant(rows, std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

Clusters as_learnt_by(const Method& method, Clusters training) {
  if (method.filter != nullptr) training.bias_deg_per_h = method.filter(training);
  return training;
}

Result<std::vector<FoldData>> split_at_folds(const TrainingSet& training_set, const InputPlan& inputs,
                                             const Method& method, const ProgressSink& progress) {
  std::vector<FoldData> splits;
  const std::size_t folds = training_set.folds.folds.size();
  for (std::size_t fold = 0; fold < folds; ++fold) {
    if (!keep_going(progress, "choosing inputs", static_cast<double>(fold) / static_cast<double>(folds))) {
      return stopped();
    }
    const FoldRows& rows = training_set.folds.folds[fold];
    TrainingSet training = within(training_set, rows.training);
    training.clusters = as_learnt_by(method, std::move(training.clusters));
    auto preparation = prepare(inputs, training);
    if (!preparation) return failure(preparation.error());
    splits.push_back({.training = std::move(training),
                      .held_out = pick(training_set.clusters, rows.held_out),
                      .held_out_rows = rows.held_out,
                      .preparation = std::move(*preparation)});
  }
  return splits;
}

Result<Choice> choose(const std::vector<FoldData>& splits, const EstimatorOptions& estimator,
                      const ProgressSink& progress) {
  std::vector<Fold> folds;
  for (const FoldData& split : splits) {
    auto fold = fold_of(split);
    if (!fold) return failure(fold.error());
    folds.push_back(std::move(*fold));
  }
  return estimator.method.choose(folds, estimator.options, progress);
}

Result<Model> fit(const Preparation& preparation, const Clusters& training, const EstimatorOptions& estimator) {
  const auto x = scaled_inputs(preparation, training);
  if (!x) return failure(x.error());
  const Eigen::VectorXd y = scaled_target(preparation, training);
  return estimator.method.fit({*x, y, preparation.terms}, estimator.parameters, estimator.options)
      .map([&](Fit&& fitted) { return assemble(preparation, std::move(fitted)); });
}

Result<Eigen::VectorXd> leave_out_residual(const std::vector<FoldData>& splits, Eigen::Index rows,
                                           const EstimatorOptions& estimator, const ProgressSink& progress) {
  Eigen::VectorXd residual = unknown(rows);
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const double done = static_cast<double>(i) / static_cast<double>(splits.size());
    if (!keep_going(progress, "leaving each fold out", done)) return stopped();
    const auto held_out = residual_of(splits[i], estimator);
    if (!held_out) return failure(held_out.error());
    residual(splits[i].held_out_rows) = *held_out;
  }
  return residual;
}

Result<Eigen::VectorXd> nested_residual(const TrainingSet& training_set, const std::vector<FoldData>& splits,
                                        const InputPlan& inputs, EstimatorOptions estimator,
                                        const ProgressSink& progress) {
  Eigen::VectorXd residual = unknown(training_set.clusters.start_s.size());
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const std::string stage = fmt::format("nested, fold {} of {}", i + 1, splits.size());
    const ProgressSink within_stage = [&](std::string_view, double fraction) {
      return keep_going(progress, stage, fraction);
    };
    // Its bias is not filtered: that is for each inner split to do.
    const auto inner = with_two_folds(within(training_set, training_set.folds.folds[i].training));
    if (!inner) return failure(inner.error());
    const auto inner_splits = split_at_folds(*inner, inputs, estimator.method, within_stage);
    if (!inner_splits) return failure(inner_splits.error());
    const auto choice = choose(*inner_splits, estimator, within_stage);
    if (!choice) return failure(choice.error());
    estimator.parameters = choice->parameters;
    const auto held_out = residual_of(splits[i], estimator);
    if (!held_out) return failure(held_out.error());
    residual(splits[i].held_out_rows) = *held_out;
  }
  return residual;
}

}  // namespace gyrotherm
