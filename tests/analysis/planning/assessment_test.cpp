// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/assessment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "analysis/model/training.hpp"
#include "analysis/planning/mission_uncertainty.hpp"
#include "analysis/planning/thermal_response.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::planning {
namespace {

data::RecordedRun recorded(const data::SyntheticRun& run = {}) {
  data::Dataset dataset = data::make_synthetic_run(run);
  data::Clusters clusters = *make_clusters(dataset);
  return {std::move(dataset), std::move(clusters)};
}

/// Returns a hold with the unit on after `off` clusters without power.
ProgramPath hold(double at_c, Eigen::Index clusters, Eigen::Index off = 0) {
  ProgramPath path;
  path.set_point_c.setConstant(clusters, at_c);
  path.start.setZero(clusters);
  path.start.head(off).setConstant(-1);
  return path;
}

model::Model trained(const data::RecordedRun& run) {
  model::TrainingOptions options;
  options.inputs = "thermal-history";
  options.method = "ridge-u";
  return *train({run.dataset}, {run.clusters}, options);
}

model::BudgetRow row_of(const model::Model& model, model::Source source) {
  return *std::ranges::find(model.uncertainty->budget.rows, source, &model::BudgetRow::source);
}

TEST(MissionUncertainty, IsGreaterOutsideTheTrainedRange) {
  const data::RecordedRun run = recorded();
  const model::Model model = trained(run);
  const ThermalResponse response = *fit_response(run.dataset);
  const auto inside = mission_uncertainty(model, predict_clusters(response, recorded_path(run.dataset))),
             outside = mission_uncertainty(model, predict_clusters(response, hold(80, 100)));
  ASSERT_TRUE(inside && outside);
  EXPECT_GT(*outside, 2 * *inside);
  // Inside, it is that of the budget, but for the excess of the variance.
  EXPECT_NEAR(*inside / combined(model.uncertainty->budget.rows).expanded_deg_per_h, 1, 0.3);

  // The form of the model is less certain there, too: without a variance of the coefficients, U still grows.
  model::Model certain = model;
  certain.variance.reset();
  const auto form_inside = mission_uncertainty(certain, predict_clusters(response, recorded_path(run.dataset))),
             form_outside = mission_uncertainty(certain, predict_clusters(response, hold(80, 100)));
  ASSERT_TRUE(form_inside && form_outside);
  EXPECT_GT(*form_outside, 1.2 * *form_inside);
}

TEST(ExpectedAfter, CountsEachNewPowerOn) {
  const data::RecordedRun run = recorded();
  const model::Model model = trained(run);
  const ThermalResponse response = *fit_response(run.dataset);
  const data::Clusters mission = predict_clusters(response, hold(20, 50));
  EXPECT_DOUBLE_EQ(row_of(model, model::Source::turn_on).sensitivity, std::sqrt(2));
  const auto after = expected_after(model, mission, mission, 3);
  ASSERT_TRUE(after);
  EXPECT_NEAR(row_of(*after, model::Source::turn_on).sensitivity, std::sqrt(1.25), 1e-12);
}

TEST(ExpectedAfter, NeverRaisesTheUncertainty) {
  const data::RecordedRun run = recorded({.cycle_rates_c_per_min = {3, 5}});
  const model::Model model = trained(run);
  const ThermalResponse response = *fit_response(run.dataset);
  for (const double mission_c : {-40.0, 0.0, 20.0, 70.0}) {
    const data::Clusters mission = predict_clusters(response, hold(mission_c, 60));
    const double now = *mission_uncertainty(model, mission);
    double before = now;
    for (const Eigen::Index clusters : {0, 10, 40, 120}) {
      const data::Clusters further = predict_clusters(response, hold(mission_c, clusters));
      const auto after = expected_after(model, mission, further, 0);
      ASSERT_TRUE(after);
      const double u = *mission_uncertainty(*after, mission);
      EXPECT_LE(u, before * (1 + 1e-9)) << mission_c << " °C, " << clusters << " clusters";
      before = u;
    }
    EXPECT_LT(before, now);
  }
}

TEST(Assessment, PrefersTheBlockThatReachesTheMission) {
  const data::RecordedRun run = recorded({.cycle_rates_c_per_min = {3, 5}});
  const std::vector<ProgramPath> blocks{hold(20, 60), hold(80, 60), hold(-60, 60)};
  const auto hot = assess(run, hold(75, 100), blocks), cold = assess(run, hold(-55, 100), blocks);
  ASSERT_TRUE(hot && cold) << hot.error().what;
  ASSERT_EQ(hot->u_after_deg_per_h.size(), 3u);
  const auto best = [](const Assessment& of) {
    return std::ranges::min_element(of.u_after_deg_per_h) - of.u_after_deg_per_h.begin();
  };
  EXPECT_EQ(best(*hot), 1);
  EXPECT_EQ(best(*cold), 2);
  EXPECT_FALSE(hot->uses_prior);
  EXPECT_EQ(std::ranges::max_element(hot->gains) - hot->gains.begin(), 1);
  EXPECT_EQ(std::ranges::max_element(cold->gains) - cold->gains.begin(), 2);
  for (const double gain : hot->gains) EXPECT_TRUE(gain >= 0 && gain < 1) << gain;
}

TEST(Assessment, GivesGainsThatTheNoiseDoesNotChange) {
  const std::vector<ProgramPath> blocks{hold(50, 60), hold(-20, 60, 12), hold(20, 30)};
  data::RecordedRun run = recorded({.cycle_rates_c_per_min = {3, 5}}), noisy = run;
  noisy.clusters.bias_deg_per_h +=
      0.02 * Eigen::VectorXd::LinSpaced(run.clusters.start_s.size(), 0, 900).array().sin().matrix();
  const auto calm = assess(run, hold(40, 100), blocks), other = assess(noisy, hold(40, 100), blocks);
  ASSERT_TRUE(calm && other);
  EXPECT_GT(other->u_now_deg_per_h, 1.05 * calm->u_now_deg_per_h);
  for (std::size_t i = 0; i < blocks.size(); ++i) EXPECT_NEAR(other->gains[i], calm->gains[i], 1e-6);
}

TEST(Assessment, IsTheSameForTheSameRecord) {
  const data::RecordedRun run = recorded({.cycle_rates_c_per_min = {3, 5}});
  const std::vector<ProgramPath> blocks{hold(50, 60), hold(-20, 60, 12)};
  const auto once = assess(run, hold(40, 100), blocks), again = assess(run, hold(40, 100), blocks);
  ASSERT_TRUE(once && again);
  EXPECT_EQ(once->u_now_deg_per_h, again->u_now_deg_per_h);
  EXPECT_EQ(once->u_after_deg_per_h, again->u_after_deg_per_h);
}

TEST(Assessment, KnowsNothingFromAFewMinutes) {
  data::RecordedRun run = recorded();
  std::vector<Eigen::Index> few{0, 1, 2};
  run.clusters = pick_clusters(run.clusters, few);
  const auto assessment = assess(run, hold(20, 50), std::vector<ProgramPath>{hold(50, 60)});
  ASSERT_TRUE(assessment) << assessment.error().what;
  EXPECT_TRUE(std::isinf(assessment->u_now_deg_per_h));
  EXPECT_TRUE(std::isinf(assessment->u_after_deg_per_h.front()));
}

TEST(Assessment, FailsWithoutThermometersOrForAnInvalidPrior) {
  data::RecordedRun run = recorded({.cycle_rates_c_per_min = {3, 5}});
  EXPECT_EQ(assess(run, hold(20, 50), {}, {.prior = "{"}).error().kind, FaultKind::bad_file);
  run.dataset.gradients.clear();
  EXPECT_EQ(assess(run, hold(20, 50), {}).error().kind, FaultKind::usage);
}

TEST(Assessment, EndsOnRequest) {
  const data::RecordedRun run = recorded({.cycle_rates_c_per_min = {3, 5}});
  const auto stopped = assess(run, hold(20, 50), {}, {}, [](std::string_view, double) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().kind, FaultKind::interrupted);
  const auto before_prior = assess(run, hold(20, 50), {}, {.prior = "{"},
                                   [](std::string_view stage, double) { return stage != "type prior"; });
  ASSERT_FALSE(before_prior);
  EXPECT_EQ(before_prior.error().kind, FaultKind::interrupted) << "after the model of the unit's own record";
}

}  // namespace
}  // namespace gyrotherm::planning
