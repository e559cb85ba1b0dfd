#include "analysis/training.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/fitting.hpp"
#include "analysis/folds.hpp"
#include "freeimu.hpp"
#include "synthetic_run.hpp"

namespace gyrotherm {
namespace {

Result<Model> train_on(const Dataset& dataset, const TrainingOptions& options, const ProgressSink& progress = {}) {
  return train({dataset}, {*make_clusters(dataset)}, options, progress);
}

TrainingOptions linear(const std::string& inputs) {
  TrainingOptions options;
  options.inputs = inputs;
  options.method = "linear";
  return options;
}

TrainingOptions quick_svr(const std::string& inputs) {
  TrainingOptions options;
  options.inputs = inputs;
  options.quick = true;
  return options;
}

TEST(LinearModel, OfARealRecordLeavesTheReferenceResiduals) {
  struct Law {
    const char* inputs;
    double residual_deg_per_h[3];
  };
  const Law laws[] = {{"die", {22.671, 11.352, 9.794}},
                      {"die,die^2", {13.329, 10.300, 10.046}},
                      {"die,barometer", {16.476, 10.414, 10.060}},
                      {"die,die-barometer", {16.476, 10.414, 10.060}}};
  for (const FreeImuAxis axis : {FreeImuAxis::x, FreeImuAxis::y, FreeImuAxis::z}) {
    const auto dataset = load_freeimu(axis);
    if (!dataset) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
    for (const Law& law : laws) {
      const auto model = train_on(*dataset, linear(law.inputs));
      ASSERT_TRUE(model) << text(model.error());
      EXPECT_NEAR(model->residual_std_deg_per_h, law.residual_deg_per_h[static_cast<int>(axis)], 5.1e-4) << law.inputs;
      EXPECT_EQ(model->folds, "4 consecutive blocks");
    }
  }
}

TEST(LinearModel, KeepsItsDigitsWhereInputsDependOnEachOther) {
  const Dataset dataset = make_synthetic_run({});
  const auto seven = train_on(dataset, linear("seven-point"));
  TrainingOptions all = linear("multi-point");
  all.threshold = 0;  // 28 gradients of rank 7
  const auto twenty_eight = train_on(dataset, all);
  ASSERT_TRUE(seven);
  ASSERT_TRUE(twenty_eight);
  EXPECT_EQ(twenty_eight->terms.size(), 28u);
  EXPECT_NEAR(seven->in_sample.std, twenty_eight->in_sample.std, 1e-12);
  EXPECT_NEAR(seven->residual_std_deg_per_h, twenty_eight->residual_std_deg_per_h, 1e-12);
}

TEST(Folds, AreTheCyclesOfEachRecord) {
  const Clusters a = *make_clusters(make_synthetic_run({}));
  const auto plan = plan_folds({a, a});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->count, 8);
  EXPECT_EQ(plan->statement, "leave one cycle out (8)");
  std::size_t rows = 0;
  for (int fold = 0; fold < plan->count; ++fold) {
    rows += rows_in(*plan, fold).size();
    EXPECT_EQ(rows_in(*plan, fold).size() + rows_outside(*plan, fold).size(), plan->fold.size());
  }
  EXPECT_EQ(rows, plan->fold.size());
}

TEST(Folds, AreFourBlocksWhereThereAreNoCycles) {
  Clusters clusters = *make_clusters(make_synthetic_run({}));
  clusters.cycle.setConstant(-1);
  const auto plan = plan_folds({clusters});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->count, 4);
  EXPECT_TRUE(std::ranges::is_sorted(plan->fold));
  EXPECT_FALSE(plan_folds({pick(clusters, {0, 1, 2, 3, 4, 5, 6})}));
}

TEST(Folds, TakeClustersOutsideCyclesWithTheCycleBefore) {
  Clusters clusters = pick(*make_clusters(make_synthetic_run({})), {0, 1, 2, 3, 4, 5});
  clusters.cycle << -1, 0, -1, 1, 1, -1;
  EXPECT_EQ(plan_folds({clusters})->fold, (std::vector<int>{0, 0, 0, 1, 1, 1}));
}

TEST(Preparation, LearnsNothingFromTheHeldOutClusters) {
  const Dataset dataset = make_synthetic_run({});
  const Clusters clusters = *make_clusters(dataset);
  const FoldPlan folds = *plan_folds({clusters});
  const InputPlan plan = *plan_inputs("multi-point", dataset, 0.9);
  const auto clean = prepare(plan, pick(clusters, rows_outside(folds, 2)));
  Clusters spoilt = clusters;
  for (const Eigen::Index k : rows_in(folds, 2)) {
    spoilt.temperature_c.row(k) *= -3;
    spoilt.bias_deg_per_h(k) += 100;
  }
  const auto same = prepare(plan, pick(spoilt, rows_outside(folds, 2)));
  ASSERT_TRUE(clean);
  ASSERT_TRUE(same);
  EXPECT_EQ(clean->terms, same->terms);
  EXPECT_EQ(clean->scaling.mean, same->scaling.mean);
  EXPECT_EQ(clean->target_std_deg_per_h, same->target_std_deg_per_h);
}

TEST(Training, CompensatesToNearTheFloorWithSupportVectors) {
  const Dataset dataset = make_synthetic_run({});
  const auto model = train_on(dataset, quick_svr("multi-point"));
  ASSERT_TRUE(model) << text(model.error());
  const double raw = figures_of(make_clusters(dataset)->bias_deg_per_h).std;
  EXPECT_LT(model->leave_cycle_out.std, 0.35 * raw);
  EXPECT_EQ(model->folds, "leave one cycle out (4)");
  EXPECT_TRUE(model->quick);
  const auto& svr = std::get<SvrModel>(model->function);
  EXPECT_LE(svr.relative_gap, 1e-6) << "the model that is kept has the tight certificate";
  EXPECT_GT(svr.beta.size(), 0);
  EXPECT_EQ(svr.parameters.C, model->tuning.best.C);
  EXPECT_EQ(model->leave_cycle_out_residual.size(), model->in_sample.count);
  EXPECT_FALSE(model->selection.statement.empty());
}

TEST(Training, OfThreePointsSaysThatAStandInWasUsed) {
  const auto model = train_on(make_synthetic_run({}), linear("three-point"));
  ASSERT_TRUE(model);
  EXPECT_EQ(model->terms,
            (std::vector<Term>{
                {TermKind::gradient, "A", "D"}, {TermKind::gradient, "A", "G"}, {TermKind::gradient, "D", "G"}}));
  EXPECT_TRUE(std::ranges::any_of(model->warnings, [](const std::string& w) { return w.find("stands in") != w.npos; }));
}

TEST(Training, AddsTheTemperatureThatGradientsCannotSee) {
  SyntheticRun run;
  run.absolute_deg_per_h_per_c = 5e-4;
  const Dataset dataset = make_synthetic_run(run);
  const auto blind = train_on(dataset, linear("multi-point")), seeing = train_on(dataset, linear("multi-point-t"));
  ASSERT_TRUE(blind && seeing);
  EXPECT_EQ(text(seeing->terms.back()), "A");
  EXPECT_LT(seeing->leave_cycle_out.std, blind->leave_cycle_out.std);
}

TEST(Training, NamesWhatIsWrong) {
  const Dataset dataset = make_synthetic_run({});
  EXPECT_NE(train_on(dataset, linear("multi-piont")).error().what.find("\"multi-point\""), std::string::npos);
  EXPECT_FALSE(train_on(dataset, linear("A,A")));
  TrainingOptions options;
  options.method = "liner";
  EXPECT_NE(train_on(dataset, options).error().what.find("did you mean linear"), std::string::npos);
  EXPECT_FALSE(train({}, {}, {}));
  Dataset nameless = dataset;
  nameless.three_point.clear();
  EXPECT_EQ(train_on(nameless, linear("three-point")).error().kind, FaultKind::usage);
}

TEST(Training, StopsWhenAsked) {
  const auto model = train_on(make_synthetic_run({}), linear("A-B"), [](std::string_view, double) { return false; });
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, FaultKind::interrupted);
}

}  // namespace
}  // namespace gyrotherm
