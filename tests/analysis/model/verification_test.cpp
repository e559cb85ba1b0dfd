// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/verification.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analysis/model/training.hpp"
#include "tests/analysis/small_model.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

data::Dataset unseen_run() {
  data::SyntheticRun run;
  run.run_id = "synthetic-2";
  run.cycle_rates_c_per_min = {3.5};
  run.seed = 2;
  return make_synthetic_run(run);
}

bool has_warning(const Verification& result, const char* words) {
  return std::ranges::any_of(result.warnings, [&](const std::string& w) { return w.find(words) != w.npos; });
}

class LinearModelVerification : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    TrainingOptions options;
    options.inputs = "seven-point";
    options.method = "linear";
    const data::Dataset dataset = data::make_synthetic_run({});
    model_ = *train({dataset}, {*make_clusters(dataset)}, options);
  }
  static Verification verified(const data::Dataset& dataset) {
    return *verify(model_, dataset, *make_clusters(dataset));
  }
  static inline Model model_;
};

TEST_F(LinearModelVerification, EvaluatesUnseenRecord) {
  const Verification result = verified(unseen_run());
  EXPECT_FALSE(result.trained_on_this);
  EXPECT_LT(result.compensated.std, 0.3 * result.raw.std);
  EXPECT_GT(result.compensated.std, result.floor.deg_per_h * 0.7);
  EXPECT_NEAR(result.floor.deg_per_h, 0.002, 0.0008) << "0.02 °/h over one second";
}

/// The true bias is the prediction minus 0.01 °/h, plus deviations of 0.003 °/h with alternating sign.
TEST_F(LinearModelVerification, ReportsErrorRelativeToTrueBias) {
  data::Dataset dataset = unseen_run();
  const data::Clusters clusters = *make_clusters(dataset);
  EXPECT_FALSE(verified(dataset).to_truth) << "the true bias of a real gyro is unknown";
  const Eigen::VectorXd predicted = clusters.bias_deg_per_h - verified(dataset).residual_deg_per_h;
  data::Clusters known = clusters;
  known.true_bias_deg_per_h = predicted.array() - 0.01;
  for (Eigen::Index k = 0; k < predicted.size(); ++k) known.true_bias_deg_per_h(k) += k % 2 == 0 ? 0.003 : -0.003;
  const auto to_truth = verify(model_, dataset, known)->to_truth;
  ASSERT_TRUE(to_truth);
  EXPECT_FALSE(to_truth->mean_removed);
  EXPECT_EQ(to_truth->figures.count, predicted.size());
  EXPECT_NEAR(to_truth->figures.mean, 0.01, 1e-4);
  EXPECT_NEAR(to_truth->figures.std, 0.003, 1e-4);
  EXPECT_NEAR(to_truth->figures.rmse, std::hypot(0.01, 0.003), 1e-4);
}

TEST_F(LinearModelVerification, RemovesMeanErrorIfReferenceIsMeanOfRecord) {
  data::Dataset dataset = unseen_run();
  dataset.has_own_reference = true;
  data::Clusters clusters = *make_clusters(dataset);
  clusters.true_bias_deg_per_h = clusters.bias_deg_per_h - verified(dataset).residual_deg_per_h;
  clusters.true_bias_deg_per_h.array() += 0.5;
  const auto to_truth = verify(model_, dataset, clusters)->to_truth;
  ASSERT_TRUE(to_truth);
  EXPECT_TRUE(to_truth->mean_removed);
  EXPECT_NEAR(to_truth->figures.rmse, 0, 1e-12);
}

TEST_F(LinearModelVerification, WarnsIfInSample) {
  const Verification result = verified(data::make_synthetic_run({}));
  EXPECT_TRUE(result.trained_on_this);
  EXPECT_TRUE(has_warning(result, "in-sample"));
  EXPECT_EQ(result.outside.clusters, 0);
  EXPECT_EQ(result.outside.farthest_term, "");
}

TEST_F(LinearModelVerification, GivesVerdict) {
  const Verification unseen = verified(unseen_run());
  EXPECT_EQ(unseen.verdict.gain, Gain::improves) << unseen.verdict.statement;
  EXPECT_TRUE(unseen.verdict.intervals_hold.value_or(false));
  const Verification seen = verified(data::make_synthetic_run({}));
  EXPECT_EQ(seen.verdict.gain, Gain::in_sample);
  EXPECT_FALSE(seen.verdict.intervals_hold.has_value());
}

/// All means have the same offset of 12 °/h, as with a model of another unit.
TEST_F(LinearModelVerification, NamesOffsetAndIntervalsThatDoNotHold) {
  data::Dataset dataset = unseen_run();
  dataset.bias_deg_per_h.array() += 12;
  const Verification result = verified(dataset);
  EXPECT_EQ(result.verdict.gain, Gain::improves) << "both have the offset: " << result.verdict.statement;
  ASSERT_TRUE(result.coverage);
  EXPECT_EQ(result.coverage->seen, 0);
  EXPECT_FALSE(result.verdict.intervals_hold.value_or(true));
  EXPECT_TRUE(has_warning(result, "the intervals do not hold: 0.0 % of"));
  Model shifted = model_;
  shifted.target_mean_deg_per_h += 12;
  const data::Dataset unshifted = unseen_run();
  const Verification worse = *verify(shifted, unshifted, *make_clusters(unshifted));
  EXPECT_EQ(worse.verdict.gain, Gain::does_not_improve) << worse.verdict.statement;
  EXPECT_TRUE(has_warning(worse, "no better than no model: compensated bias std"));
}

TEST_F(LinearModelVerification, WarnsOfAnotherGyro) {
  data::Dataset trained = data::make_synthetic_run({}), unseen = unseen_run();
  trained.identity = unseen.identity = "0042";
  TrainingOptions options;
  options.inputs = "seven-point";
  options.method = "linear";
  const Model model = *train({trained}, {*make_clusters(trained)}, options);
  const auto back = model_from_json(to_json(model), "model.json");
  ASSERT_TRUE(back) << text(back.error());
  const data::Clusters clusters = *make_clusters(unseen);
  EXPECT_FALSE(has_warning(*verify(*back, unseen, clusters), "another gyro"));
  unseen.identity = "0043";
  EXPECT_TRUE(
      has_warning(*verify(*back, unseen, clusters), "another gyro: it was trained on 0042, this record is of 0043"));
  unseen.identity.clear();
  EXPECT_FALSE(has_warning(*verify(*back, unseen, clusters), "another gyro"));
}

TEST_F(LinearModelVerification, WarnsOfAnotherBiasReference) {
  data::Dataset unseen = unseen_run();
  const data::Clusters clusters = *make_clusters(unseen);
  const auto model = model_from_json(to_json(model_), "model.json");
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_FALSE(has_warning(*verify(*model, unseen, clusters), "trained with the bias reference"));
  unseen.bias_zero = "nothing removed";
  EXPECT_TRUE(
      has_warning(*verify(*model, unseen, clusters),
                  "trained with the bias reference \"earth rate removed\", but this record uses \"nothing removed\""));
}

TEST_F(LinearModelVerification, WarnsOfStepByTurningUnit) {
  data::Dataset unseen = unseen_run();
  const data::Clusters clusters = *make_clusters(unseen);
  const char* jumps = "results over both positions contain a step of twice the Earth rate";
  unseen.earth_rate_deg_per_h.reset();
  EXPECT_FALSE(has_warning(*verify(model_, unseen, clusters), jumps));
  unseen.segments.back().unit.turned = true;
  EXPECT_TRUE(has_warning(*verify(model_, unseen, clusters), jumps));
  unseen.earth_rate_deg_per_h = 10;
  EXPECT_FALSE(has_warning(*verify(model_, unseen, clusters), jumps))
      << "the Earth rate is removed with the sign of each position";
}

TEST_F(LinearModelVerification, WarnsOfAnotherAxis) {
  data::Dataset unseen = unseen_run();
  const data::Clusters clusters = *make_clusters(unseen);
  Model model = model_;
  const auto of_another = [&](const data::AxisChoice& trained, const data::AxisChoice& of) {
    model.trained_on.front().of = trained;
    unseen.of = of;
    return has_warning(*verify(model, unseen, clusters), "another axis");
  };
  EXPECT_TRUE(of_another({.unit = "u", .axis = "x"}, {.unit = "u", .axis = "y"}));
  EXPECT_TRUE(has_warning(*verify(model, unseen, clusters), "it was trained on u.x, this is u.y"));
  EXPECT_FALSE(of_another({.unit = "u", .axis = "x"}, {.unit = "u", .axis = "x"}));
  EXPECT_FALSE(of_another({.unit = "u", .axis = "x"}, {})) << "a record with one axis";
  EXPECT_FALSE(of_another({.unit = "u1"}, {.unit = "u2"})) << "the identity decides, not the name";
}

TEST_F(LinearModelVerification, SeparatesRampsHoldsAndCorners) {
  const data::Dataset dataset = unseen_run();
  const Verification result = verified(dataset);
  EXPECT_EQ(result.ramps.count + result.holds.count, result.compensated.count);
  EXPECT_EQ(result.segments.size(), dataset.segments.size());
  EXPECT_DOUBLE_EQ(result.segments.front().duration_s, 1500);
  EXPECT_TRUE(result.segments.front().hold);
  EXPECT_GE(result.corners.count, 6 * 6) << "six corners with at least six clusters each";
  EXPECT_LE(result.corners.count, 6 * 7);
}

TEST_F(LinearModelVerification, CountsClustersOutsideTrainedRange) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 300, 1).array() += 30;
  const Verification result = verified(dataset);
  EXPECT_EQ(result.outside.clusters, 3);
  EXPECT_TRUE(result.outside.farthest_term.starts_with("A-")) << result.outside.farthest_term;
  EXPECT_GT(result.outside.farthest, 1) << "30 °C outside a range of a few kelvins";
  EXPECT_TRUE(has_warning(result, "the plane is extrapolated"));
  EXPECT_TRUE(has_warning(result, "3 of "));
  EXPECT_TRUE(has_warning(result, " clusters have an input outside the trained range"));
  dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 100, 1).array() += 30;
  EXPECT_TRUE(has_warning(verified(dataset), " clusters has an input outside the trained range")) << "one cluster";
}

TEST_F(LinearModelVerification, AppliesPolicyOutsideRange) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 300, 1).array() += 30;
  const data::Clusters clusters = *make_clusters(dataset);
  const auto with = [&](Outside outside) { return *verify(model_, dataset, clusters, outside); };
  const Verification continued = with(Outside::continued), refused = with(Outside::refuse);
  const Verification extrapolated = with(Outside::extrapolate);
  EXPECT_EQ(continued.residual_deg_per_h, extrapolated.residual_deg_per_h) << "a linear model is a plane";
  EXPECT_EQ(refused.compensated.count, continued.compensated.count - 3);
  EXPECT_EQ(refused.ramps.count + refused.holds.count, refused.compensated.count);
  EXPECT_LE(refused.compensated.max_abs, continued.compensated.max_abs);
  EXPECT_TRUE(std::isnan(refused.residual_deg_per_h(0)));
  EXPECT_EQ(refused.raw.count, refused.compensated.count) << "both are figures of the same clusters";
  EXPECT_EQ(continued.raw.count, continued.compensated.count);
  EXPECT_TRUE(has_warning(refused, "excluded from the results"));
  EXPECT_TRUE(has_warning(extrapolated, "whole model is extrapolated"));
}

/// The three refused clusters have a large bias, which the model would otherwise seem to remove.
TEST_F(LinearModelVerification, ComparesRawBiasOfSameClusters) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.block(0, 0, 300, 1).array() += 30;
  dataset.bias_deg_per_h.head(300).array() += 50;
  const data::Clusters clusters = *make_clusters(dataset);
  const Verification refused = *verify(model_, dataset, clusters, Outside::refuse);
  const auto rows = data::finite_rows(refused.residual_deg_per_h);
  EXPECT_EQ(std::ssize(rows), clusters.start_s.size() - 3);
  EXPECT_EQ(refused.raw.std, compute_figures(clusters.bias_deg_per_h(rows), clusters, rows).std);
  EXPECT_LT(refused.raw.max_abs, 50);
  TrainingOptions options;
  options.inputs = "rates";
  options.method = "linear";
  const data::Dataset trained = data::make_synthetic_run({});
  const Model of_rates = *train({trained}, {*make_clusters(trained)}, options);
  const Verification without_first = *verify(of_rates, dataset, clusters);
  EXPECT_EQ(without_first.raw.count, clusters.start_s.size() - 1) << "the first cluster has no rate";
  EXPECT_EQ(without_first.compensated.count, without_first.raw.count);
}

TEST_F(LinearModelVerification, RefusesRecordEntirelyOutside) {
  data::Dataset dataset = unseen_run();
  dataset.temperature_c.col(0).array() += 30;
  const auto result = verify(model_, dataset, *make_clusters(dataset), Outside::refuse);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, FaultKind::usage);
  EXPECT_EQ(result.error().what,
            "every cluster with all inputs has an input outside the trained range, which the policy refuses");
}

TEST_F(LinearModelVerification, ReportsMissingInputs) {
  TrainingOptions options;
  options.inputs = "rates";
  options.method = "linear";
  const data::Dataset dataset = unseen_run();
  const data::Clusters clusters = *make_clusters(dataset);
  const Model of_rates = *train({dataset}, {clusters}, options);
  for (const Outside outside : {Outside::continued, Outside::refuse}) {
    // The first cluster of a run has no rate.
    const auto result = verify(of_rates, dataset, pick_clusters(clusters, {0}), outside);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, FaultKind::usage);
    EXPECT_EQ(result.error().what, "no cluster has all inputs of the model (a rate needs the previous cluster)");
  }
}

TEST_F(LinearModelVerification, StatesUncertaintyOfFigures) {
  const Verification result = verified(unseen_run());
  for (const data::Figures* figures :
       {&result.raw, &result.compensated, &result.ramps, &result.holds, &result.corners}) {
    EXPECT_GE(figures->effective.of_std, 1);
    EXPECT_LE(figures->effective.of_std, figures->count);
    EXPECT_GT(standard_error_of_std(*figures), 0);
  }
  EXPECT_LT(result.raw.effective.of_std, 0.2 * result.raw.count) << "the raw bias follows the temperature";
  EXPECT_GT(result.compensated.effective.of_std, result.raw.effective.of_std);
}

TEST_F(LinearModelVerification, ComputesExpectedInSampleResidual) {
  const Verification in_sample = verified(data::make_synthetic_run({}));
  EXPECT_EQ(in_sample.effective_parameters, 8);
  const double part = 1 - 8.0 / in_sample.compensated.count;
  EXPECT_DOUBLE_EQ(in_sample.expected_in_sample_std, in_sample.floor.deg_per_h * std::sqrt(part));
  EXPECT_TRUE(std::isnan(verified(unseen_run()).expected_in_sample_std));

  const data::Dataset dataset = data::make_synthetic_run({});
  const data::Clusters clusters = *make_clusters(dataset);
  std::vector<Eigen::Index> quarter(static_cast<std::size_t>(clusters.start_s.size() / 4));
  std::iota(quarter.begin(), quarter.end(), 0);
  const auto of_a_part = verify(model_, dataset, pick_clusters(clusters, quarter));
  ASSERT_TRUE(of_a_part);
  EXPECT_DOUBLE_EQ(of_a_part->expected_in_sample_std, of_a_part->floor.deg_per_h * std::sqrt(part))
      << "a quarter of the parameters belongs to a quarter of the clusters";
}

TEST_F(LinearModelVerification, WarnsIfReferenceIsMeanOfRecord) {
  constexpr const char* kWords = "the bias reference is computed from this record";
  data::Dataset dataset = unseen_run();
  EXPECT_FALSE(has_warning(verified(dataset), kWords));
  dataset.bias_zero = "mean of the first hold removed";
  dataset.has_own_reference = true;
  EXPECT_TRUE(has_warning(verified(dataset), kWords));
}

/// A constant is not an error of the intervals if the zero of the bias is unknown, whatever its size.
TEST_F(LinearModelVerification, DoesNotJudgeIntervalsIfZeroIsUnknown) {
  for (const double constant : {0.0, 0.02, 12.0}) {
    SCOPED_TRACE(constant);
    data::Dataset dataset = unseen_run();
    dataset.bias_deg_per_h.array() += constant;
    dataset.bias_zero = data::kOwnReference;
    dataset.has_own_reference = true;
    const Verification result = verified(dataset);
    EXPECT_FALSE(result.coverage);
    EXPECT_FALSE(result.verdict.intervals_hold.has_value());
    EXPECT_EQ(result.verdict.gain, Gain::improves) << "the STD still counts";
    EXPECT_FALSE(has_warning(result, "the intervals do not hold"));
    EXPECT_TRUE(has_warning(result, "mean, RMSE and maximum of the residual contain an unknown constant"));
    EXPECT_TRUE(has_warning(result, "; the intervals are not judged"));
    EXPECT_FALSE(has_warning(result, "exclude a constant"));
    Model without = model_;
    without.uncertainty.reset();
    EXPECT_FALSE(has_warning(*verify(without, dataset, *make_clusters(dataset)), "not judged"));
  }
}

TEST_F(LinearModelVerification, WarnsIfReferencesAreMeansOfDifferentRecords) {
  constexpr const char* kWords = "are means of different records (mean of the first hold removed)";
  data::Dataset trained = data::make_synthetic_run({}), unseen = unseen_run();
  for (data::Dataset* dataset : {&trained, &unseen}) {
    dataset->bias_zero = data::kOwnReference;
    dataset->has_own_reference = true;
  }
  TrainingOptions options;
  options.inputs = "seven-point";
  options.method = "linear";
  const Model model = *train({trained}, {*make_clusters(trained)}, options);
  const auto back = model_from_json(to_json(model), "model.json");
  ASSERT_TRUE(back) << text(back.error());
  EXPECT_TRUE(has_warning(*verify(*back, unseen, *make_clusters(unseen)), kWords));
  EXPECT_FALSE(has_warning(*verify(*back, trained, *make_clusters(trained)), kWords)) << "the same record";
  EXPECT_TRUE(origin_warnings(*back, {.bias_zero = ""}).empty()) << "unknown";
  EXPECT_EQ(origin_warnings(*back, {.bias_zero = std::string(data::kOwnReference)}).size(), 1u)
      << "a record without identity is another one";
  unseen.bias_zero = "earth rate removed";
  unseen.has_own_reference = false;
  EXPECT_TRUE(has_warning(*verify(*back, unseen, *make_clusters(unseen)), "this record uses \"earth rate removed\""));
}

TEST_F(LinearModelVerification, WarnsOfResidualBelowFloor) {
  const data::Dataset dataset = unseen_run();
  const data::Clusters clusters = *make_clusters(dataset);
  data::Clusters flattered = clusters;
  flattered.bias_deg_per_h = *predict(model_, clusters);
  const auto result = verify(model_, dataset, flattered);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->compensated.std, 0, 1e-12);
  EXPECT_TRUE(has_warning(*result, "over-fit"));
}

TEST_F(LinearModelVerification, WarnsOfDifferentClusterLength) {
  const data::Dataset dataset = unseen_run();
  const auto result = verify(model_, dataset, *make_clusters(dataset, 50));
  EXPECT_TRUE(has_warning(*result, "over 50 s"));
}

/// Returns a run whose thermometers were calibrated on the same day, of a gyro without turn-on scatter.
data::Dataset well_known_run(const data::SyntheticRun& run) {
  data::Dataset dataset = make_synthetic_run(run);
  dataset.thermometer_uncertainty.assign(
      8, {.calibration = Kelvins{0.02}, .drift_in_a_year = Kelvins{0.05}, .calibrated = std::chrono::sys_days{}});
  dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h = 0;
  return dataset;
}

TEST(Coverage, EqualsNominalShareForKnownNoise) {
  TrainingOptions options;
  options.inputs = "physics";
  options.method = "linear";
  const data::Dataset dataset = well_known_run({});
  const Model model = *train({dataset}, {*make_clusters(dataset)}, options);
  double within = 0;
  int clusters = 0;
  for (std::uint64_t seed = 2; seed < 6; ++seed) {
    const data::Dataset unseen = well_known_run({.run_id = "unseen", .seed = seed});
    const Verification result = *verify(model, unseen, *make_clusters(unseen));
    ASSERT_TRUE(result.coverage);
    EXPECT_EQ(result.coverage->nominal, 0.95);
    // Insignificant estimates of flicker, random walk and model form remain in the budget and widen the interval
    // slightly.
    EXPECT_GT(result.coverage->mean_half_width_deg_per_h, 0.95 * 1.96 * 0.02 / 10);
    EXPECT_LT(result.coverage->mean_half_width_deg_per_h, 1.2 * 1.96 * 0.02 / 10);
    EXPECT_GT(result.coverage->effective, 0.5 * result.coverage->clusters) << "white noise";
    within += result.coverage->seen * result.coverage->clusters;
    clusters += result.coverage->clusters;
  }
  EXPECT_GT(clusters, 1000);
  EXPECT_NEAR(within / clusters, 0.96, 0.025);
}

TEST_F(LinearModelVerification, WidensIntervalsForThermometerDrift) {
  data::Dataset dataset = unseen_run();
  dataset.started_utc = std::chrono::days(400);
  const auto half_width = [&](double drift_k, int days_since) {
    dataset.thermometer_uncertainty.assign(8,
                                           {.drift_in_a_year = Kelvins{drift_k},
                                            .calibrated = std::chrono::sys_days(std::chrono::days(400 - days_since))});
    return verified(dataset).coverage->mean_half_width_deg_per_h;
  };
  EXPECT_GT(half_width(0.1, 365), half_width(0.1, 10));
  EXPECT_GT(half_width(0.1, 100), half_width(0.05, 100));
  const double none = half_width(0.05, 0);
  dataset.thermometer_uncertainty.clear();
  EXPECT_NEAR(verified(dataset).coverage->mean_half_width_deg_per_h, none, 1e-12)
      << "the interval is unknown, and one year is assumed";
}

TEST_F(LinearModelVerification, HasNoCoverageWithoutBudget) {
  Model model = model_;
  model.uncertainty.reset();
  const data::Dataset dataset = unseen_run();
  EXPECT_FALSE(verify(model, dataset, *make_clusters(dataset))->coverage);
}

/// The true bias follows a sinusoidal temperature. Means of the stream are compared with means of the true bias.
TEST(AsStreamed, ReportsErrorCausedByLag) {
  constexpr Eigen::Index kRows = 20000;
  data::Dataset dataset;
  dataset.thermometers = {"A"};
  dataset.time_s = Eigen::VectorXd::LinSpaced(kRows, 0, kRows - 1);
  dataset.temperature_c = 20 + 5 * (dataset.time_s.array() * (2 * std::numbers::pi / 3600)).sin();
  dataset.set_point_c = dataset.temperature_c.col(0);
  dataset.segment.setConstant(kRows, -1);
  dataset.cycle.setConstant(kRows, -1);
  dataset.bias_deg_per_h = 0.1 * (dataset.temperature_c.col(0).array() - 20);
  dataset.true_bias_deg_per_h = dataset.bias_deg_per_h;
  const data::Clusters clusters = *make_clusters(dataset);
  Model model = data::small_slope_model();
  const auto stream_results = [&] {
    const auto verification = verify(model, dataset, clusters);
    return *evaluate_stream(model, dataset, clusters, verification->residual_deg_per_h);
  };
  const StreamResult lagging = stream_results();
  model.latency = {.lag_s = 50, .is_led = true};
  const StreamResult led = stream_results();
  EXPECT_LT(lagging.aligned.std, 1e-9);
  // A sine with an amplitude of 0.5 °/h and a period of 3600 s that lags by 49.5 s, in means over 100 s.
  EXPECT_NEAR(lagging.residual.std, 0.5 / std::numbers::sqrt2 * 2 * std::numbers::pi * 49.5 / 3600, 0.001);
  EXPECT_LT(led.residual.std, 0.3 * lagging.residual.std);
  ASSERT_TRUE(led.to_truth && lagging.to_truth);
  EXPECT_NEAR(led.to_truth->figures.std, led.residual.std, 1e-9);
  EXPECT_EQ(led.residual.count, lagging.residual.count) << "both use the same clusters";
}

TEST(RunScatter, UsesOnlyUnseenRuns) {
  const auto run = [](const char* id, double mean, bool trained) {
    Verification one;
    one.run_id = id;
    one.trained_on_this = trained;
    one.compensated.mean = mean;
    return one;
  };
  const auto between = compute_run_scatter({run("a", 0.001, false), run("b", 9, true), run("c", 0.005, false),
                                            run("a", 0.001, false), run("d", 0.003, false)});
  ASSERT_TRUE(between);
  EXPECT_EQ(between->runs, 3);
  EXPECT_EQ(between->degrees_of_freedom, 2);
  EXPECT_NEAR(between->mean_deg_per_h, 0.003, 1e-15);
  EXPECT_NEAR(between->std_deg_per_h, 0.002, 1e-15);
  EXPECT_NEAR(between->expanded_deg_per_h, 4.303 * 0.002, 1e-5);
  EXPECT_FALSE(compute_run_scatter({run("a", 1, false), run("b", 2, true)}));
}

TEST(RunScatter, RequiresOneGyro) {
  Verification a, b;
  a.run_id = a.identity = "a";
  b.run_id = b.identity = "b";
  EXPECT_FALSE(compute_run_scatter({a, b})) << "runs of different gyros do not show repeatability";
  b.identity.clear();
  EXPECT_TRUE(compute_run_scatter({a, b})) << "a run without identity may be of the same gyro";
}

TEST(RunScatter, RequiresOneIndependentBiasReference) {
  const auto run = [](const char* id, double mean, const char* zero, bool own) {
    Verification one;
    one.run_id = id;
    one.compensated.mean = mean;
    one.bias_zero = zero;
    one.has_own_reference = own;
    return one;
  };
  const auto a = run("a", 0.001, "earth rate removed", false), b = run("b", 0.004, "earth rate removed", false);
  const auto own = run("c", 0, "mean of the first hold removed", true), also_own = run("d", 0, "of it", true);
  const auto between = compute_run_scatter({a, own, b, also_own});
  ASSERT_TRUE(between);
  EXPECT_EQ(between->runs, 2);
  EXPECT_FALSE(compute_run_scatter({own, also_own})) << "each reference removed the mean of its own run";
  EXPECT_FALSE(compute_run_scatter({a, b, run("e", 10.6, "nothing removed", false)}))
      << "one bias includes the Earth rate";
}

}  // namespace
}  // namespace gyrotherm::model
