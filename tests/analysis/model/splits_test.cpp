#include "analysis/model/splits.hpp"

#include <gtest/gtest.h>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm {
namespace {

/// "Chooses" the sum of all targets that it is shown, in °/h, and predicts that everywhere: whatever it was shown can
/// be read off its predictions.
Result<Choice> choose_sum(std::span<const Fold> folds, const MethodOptions&, const ProgressSink&) {
  double sum = 0;
  for (const Fold& fold : folds)
    sum += fold.target_scale * (fold.train_y.cwiseAbs().sum() + fold.test_y.cwiseAbs().sum());
  return Choice{.parameters = {{"sum", sum}}, .tuning = {}, .warnings = {}};
}

Result<Fit> fit_constant(const FitInput& set, const HyperParameters& parameters, const MethodOptions&) {
  return Fit{.function = LinearModel{.weights = Eigen::VectorXd::Zero(set.x.cols()), .b = value_of(parameters, "sum")},
             .effective_parameters = 1,
             .particulars = {}};
}

Eigen::VectorXd doubled(const Clusters& training) { return 2 * training.bias_deg_per_h; }

constexpr Method kSpy{
    .name = "spy", .title = "", .citation = "", .inputs = "", .choose = choose_sum, .fit = fit_constant};

Eigen::VectorXd nested_predictions(const TrainingSet& training_set, const InputPlan& plan) {
  const auto splits = split_at_folds(training_set, plan, kSpy, {});
  const auto residual = nested_residual(training_set, *splits, plan, {kSpy, {}, {}}, {});
  return training_set.clusters.bias_deg_per_h - *residual;
}

TEST(Nested, ChoosesWithoutEverSeeingTheHeldOutFold) {
  const Dataset dataset = make_synthetic_run({});
  const Clusters clusters = *make_clusters(dataset);
  const InputPlan plan = *plan_inputs("seven-point", dataset);
  for (const FoldKind kind : {FoldKind::cycles, FoldKind::blocks}) {
    const FoldPlan folds = *plan_folds({clusters}, {.kind = kind, .guard_minutes = {}});
    const Eigen::VectorXd clean = nested_predictions({clusters, folds}, plan);
    for (const FoldRows& fold : folds.folds) {
      Clusters spoilt = clusters;
      for (const Eigen::Index k : fold.held_out) spoilt.bias_deg_per_h(k) += 1;
      const Eigen::VectorXd predicted = nested_predictions({spoilt, folds}, plan);
      EXPECT_TRUE(predicted(fold.held_out).isApprox(clean(fold.held_out), 1e-12));
      EXPECT_FALSE(predicted.isApprox(clean, 1e-3)) << "the other folds have learnt from it";
    }
  }
}

TEST(Splits, FilterWhatIsLearntFromAndNeverWhatIsHeldOut) {
  const Dataset dataset = make_synthetic_run({});
  const TrainingSet training_set{*make_clusters(dataset), *plan_folds({*make_clusters(dataset)})};
  Method filtering = kSpy;
  filtering.filter = doubled;
  const auto splits = split_at_folds(training_set, *plan_inputs("A-B", dataset), filtering, {});
  ASSERT_TRUE(splits);
  for (const FoldData& split : *splits) {
    EXPECT_EQ(split.held_out.bias_deg_per_h, training_set.clusters.bias_deg_per_h(split.held_out_rows));
    const auto& rows = training_set.folds.folds[&split - splits->data()].training;
    EXPECT_EQ(split.training.clusters.bias_deg_per_h, 2 * training_set.clusters.bias_deg_per_h(rows));
  }
}

TEST(Splits, StopWhenAsked) {
  const Dataset dataset = make_synthetic_run({});
  const TrainingSet training_set{*make_clusters(dataset), *plan_folds({*make_clusters(dataset)})};
  const auto splits =
      split_at_folds(training_set, *plan_inputs("A-B", dataset), kSpy, [](std::string_view, double) { return false; });
  ASSERT_FALSE(splits);
  EXPECT_EQ(splits.error().kind, FaultKind::interrupted);
}

}  // namespace
}  // namespace gyrotherm
