#include "analysis/model/fitting.hpp"

#include <utility>

namespace gyrotherm {

Result<Preparation> prepare(const InputPlan& plan, const TrainingSet& training) {
  auto chosen = choose_inputs(plan, training);
  if (!chosen) return failure(chosen.error());
  const auto inputs = evaluate(chosen->terms, training.clusters);
  if (!inputs) return failure(inputs.error());
  const auto scaling = fit_scaling(*inputs, chosen->terms);
  if (!scaling) return failure(scaling.error());
  const Figures target = figures_of(training.clusters.bias_deg_per_h);
  constexpr double kRounding = 1e-12;
  if (!(target.std > kRounding * target.max_abs)) {
    return failure(FaultKind::usage, "training", "the bias does not vary over the training clusters");
  }
  return Preparation{std::move(chosen->terms), std::move(chosen->selection), *scaling, target.mean, target.std};
}

Result<SampleMatrix> scaled_inputs(const Preparation& preparation, const Clusters& clusters) {
  return evaluate(preparation.terms, clusters).map([&](const SampleMatrix& inputs) {
    return apply(preparation.scaling, inputs);
  });
}

Eigen::VectorXd scaled_target(const Preparation& preparation, const Clusters& clusters) {
  return (clusters.bias_deg_per_h.array() - preparation.target_mean_deg_per_h) / preparation.target_std_deg_per_h;
}

Model assemble(const Preparation& preparation, Fit fit) {
  Model model;
  model.function = std::move(fit.function);
  model.effective_parameters = fit.effective_parameters;
  model.particulars = std::move(fit.particulars);
  model.terms = preparation.terms;
  model.scaling = preparation.scaling;
  model.target_mean_deg_per_h = preparation.target_mean_deg_per_h;
  model.target_std_deg_per_h = preparation.target_std_deg_per_h;
  model.selection = preparation.selection;
  return model;
}

}  // namespace gyrotherm
