// SPDX-License-Identifier: Apache-2.0
#include "report/report.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/report/synthetic_experiment.hpp"
#include "tests/support/markup.hpp"

namespace gyrotherm::report {
namespace {

using nlohmann::json;

TEST(ReportJson, HasStableKeys) {
  const SyntheticExperiment experiment;
  const json report = json::parse(to_json(experiment.report()));
  EXPECT_EQ(report.at("schema"), "gyrotherm-report/1");
  for (const char* pointer : {"/rig/virtual",
                              "/thermal/reason",
                              "/clusters/rate",
                              "/clusters/random",
                              "/clusters/length_s",
                              "/correlation/7/7",
                              "/correlation_signed/0/1",
                              "/correlation_temperature/7",
                              "/correlation_rate/7",
                              "/selected_pairs/0",
                              "/noise_floor_deg_per_h",
                              "/rate/noise_floor_deg_per_h",
                              "/rate/raw/std_deg_per_h",
                              "/rate/three_point/mean_deg_per_h",
                              "/rate/multi_point/rmse_deg_per_h",
                              "/rate/multi_point_t/max_abs_deg_per_h",
                              "/random/raw/std_deg_per_h",
                              "/random/multi_point_t/ramps/std_deg_per_h",
                              "/random/multi_point_t/corners/count",
                              "/rate_leave_cycle_out/nested",
                              "/rate_leave_cycle_out/multi_point/std_deg_per_h",
                              "/improvement/rate/three_point/from_original",
                              "/improvement/random/multi_point/paper_ratio",
                              "/improvement/random/multi_point_t/residual_reduction",
                              "/tuning/multi_point/seed",
                              "/tuning/multi_point/swarm/particles",
                              "/tuning/multi_point/bounds/log2_c/1",
                              "/tuning/multi_point/history/30",
                              "/tuning/multi_point/C",
                              "/tuning/multi_point/sigma",
                              "/tuning/multi_point/epsilon",
                              "/tuning/multi_point/epsilon_deg_per_h",
                              "/tuning/multi_point/support_vectors",
                              "/tuning/multi_point/certified_gap",
                              "/series/rate/time_s/0",
                              "/series/random/set_point_c/0",
                              "/series/rate/thermometers/H/0",
                              "/series/random/multi_point_t/0",
                              "/segments/0/duration_s",
                              "/provenance/rate/record_sha256",
                              "/provenance/program_version",
                              "/methods/3/random/std_deg_per_h",
                              "/methods/3/nested_leave_cycle_out/std_deg_per_h",
                              "/recommendation/recommended",
                              "/recommendation/candidates/0/expanded_uncertainty_deg_per_h",
                              "/methods/0/stored_numbers",
                              "/methods/0/citation",
                              "/methods/0/effective_parameters",
                              "/models/multi_point/stored_numbers",
                              "/rate_nested_leave_cycle_out/multi_point",
                              "/rate/noise_floor_error_deg_per_h",
                              "/rate/noise_floor_statement",
                              "/rate/raw/effective_count",
                              "/random/multi_point_t/std_error_deg_per_h",
                              "/random/multi_point_t/holds/mean_error_deg_per_h",
                              "/rate/multi_point/expected_in_sample_std_deg_per_h",
                              "/random/multi_point/outside/policy",
                              "/rate/characterisation/ramp_deg_per_h_per_k_per_min/before/u",
                              "/rate/characterisation/hysteresis_deg_per_h",
                              "/random/characterisation/statement",
                              "/rate/allan/statement",
                              "/rate/allan/curve/0/error_deg_per_h",
                              "/rate/allan/coefficients/N/value",
                              "/rate/allan/coefficients/K/at_most",
                              "/random/allan/compensated_holds/coefficients/B/at_most",
                              "/random/allan/misfit",
                              "/random/allan/whole_run/multi_point_t/0/tau_s"}) {
    EXPECT_TRUE(report.contains(json::json_pointer(pointer))) << pointer;
  }
}

TEST(ReportJson, MarksInSampleRuns) {
  const SyntheticExperiment experiment;
  const json report = json::parse(to_json(experiment.report()));
  EXPECT_EQ(report["rate"]["in_sample"], true);
  EXPECT_EQ(report["random"]["in_sample"], false);
  EXPECT_EQ(report["rate_leave_cycle_out"]["nested"], false);
}

TEST(ReportJson, HasCorrelationMagnitudeWithZeroDiagonal) {
  const SyntheticExperiment experiment;
  const json report = json::parse(to_json(experiment.report()));
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(report["correlation"][i][i], 0.0);
    for (std::size_t j = 0; j < 8; ++j) {
      EXPECT_EQ(report["correlation"][i][j], report["correlation"][j][i]);
      EXPECT_EQ(report["correlation"][i][j].get<double>(), std::abs(report["correlation_signed"][i][j].get<double>()));
    }
  }
}

TEST(ReportJson, GivesEqualBytesEachTime) {
  const SyntheticExperiment first, second;
  EXPECT_EQ(to_json(first.report()), to_json(second.report()));
}

TEST(ReportJson, ContainsNoPathOfMachine) {
  const SyntheticExperiment experiment;
  EXPECT_EQ(tests::count_occurrences(to_json(experiment.report()), "/somewhere"), 0);
}

TEST(ReportJson, DoesNotDependOnNumberOfThreads) {
  SyntheticExperiment experiment;
  const std::string one = to_json(experiment.report());
  experiment.qualification.models.multi_point.model.tuning_options.swarm.threads = 7;
  EXPECT_EQ(to_json(experiment.report()), one);
}

TEST(ReportJson, ReadsBackToEqualDoubles) {
  const SyntheticExperiment experiment;
  const json report = json::parse(to_json(experiment.report()));
  for (Eigen::Index k = 0; k < experiment.random.clusters.bias_deg_per_h.size(); ++k) {
    EXPECT_EQ(report["series"]["random"]["raw"][static_cast<std::size_t>(k)].get<double>(),
              experiment.random.clusters.bias_deg_per_h(k));
  }
}

TEST(ReportJson, WritesMissingNumberAsNull) {
  SyntheticExperiment experiment;
  experiment.qualification.models.multi_point.random.floor.deg_per_h = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(json::parse(to_json(experiment.report()))["noise_floor_deg_per_h"].is_null());
}

TEST(ReportJson, MarksRigVirtualWhenRecordIsSimulated) {
  const SyntheticExperiment experiment;
  EXPECT_EQ(json::parse(to_json(experiment.report()))["rig"]["virtual"], true);
}

TEST(ReportJson, FailsWhenOneLimitIsExceeded) {
  const SyntheticExperiment experiment;
  Report report = experiment.report();
  EXPECT_EQ(json::parse(to_json(report))["accept"]["verdict"], "PASS");
  report.accept.push_back({"random.multi_point_t.max_abs_deg_per_h", 0.001, 0.006, false});
  EXPECT_EQ(json::parse(to_json(report))["accept"]["verdict"], "FAIL");
  report.accept.clear();
  EXPECT_EQ(json::parse(to_json(report))["accept"]["verdict"], "no limit");
}

TEST(ReportJson, ListsEachWarningOnce) {
  SyntheticExperiment experiment;
  experiment.qualification.models.multi_point.random.warnings = {"3 clusters outside the trained range",
                                                                 "3 clusters outside the trained range"};
  experiment.rate.dataset.three_point_stand_in = true;
  const json warnings = json::parse(to_json(experiment.report()))["warnings"];
  EXPECT_EQ(warnings.size(), 3U) << warnings;
  EXPECT_EQ(warnings[2], "multi-point on the random run: 3 clusters outside the trained range");
}

TEST(ReportJson, DoesNotWarnThatRampRunTrainedTheModels) {
  SyntheticExperiment experiment;
  auto& trained = experiment.qualification.models.multi_point;
  const auto before = json::parse(to_json(experiment.report()))["warnings"].size();
  trained.rate.warnings = {model::kTrainedOnThisWarning, "over-fitted"};
  trained.random.warnings = {model::kTrainedOnThisWarning};
  const json warnings = json::parse(to_json(experiment.report()))["warnings"];
  ASSERT_EQ(warnings.size(), before + 2) << warnings;
  EXPECT_EQ(warnings[before], "multi-point on the ramp run: over-fitted");
  EXPECT_EQ(warnings[before + 1], std::string("multi-point on the random run: ") + model::kTrainedOnThisWarning);
}

TEST(ReportJson, ListsCyclesOfProgram) {
  const SyntheticExperiment experiment;
  const json cycles = json::parse(to_json(experiment.report()))["series"]["rate"]["cycles"];
  ASSERT_EQ(cycles.size(), 4U);
  EXPECT_EQ(cycles[1]["name"], "2 °C/min");
  EXPECT_EQ(cycles[0]["end_s"], cycles[1]["start_s"]);
}

TEST(ReportJson, HasNoiseOfHoldsWithUnitAndReadOffTime) {
  const SyntheticExperiment experiment;
  const json noise = json::parse(to_json(experiment.report()))["rate"]["allan"];
  const json n = noise["coefficients"]["N"];
  EXPECT_EQ(n["unit"], "°/√h");
  EXPECT_EQ(n["read_off_s"], 3600.0);
  EXPECT_EQ(n["seen"], true);
  EXPECT_NEAR(n["value"].get<double>(), 0.0187 / 60, 4 * n["error"].get<double>());
  EXPECT_EQ(noise["coefficients"].size(), 5u);
  for (const auto& [symbol, coefficient] : noise["coefficients"].items()) {
    EXPECT_EQ(coefficient["value"].is_null(), !coefficient["seen"].get<bool>()) << symbol;
  }
  EXPECT_EQ(noise["fitted_deg_per_h"].size(), noise["curve"].size());
}

TEST(ReportJson, WritesUnknownValuesAsNull) {
  SyntheticExperiment experiment;
  experiment.qualification.models.multi_point.model.effective_parameters = 0;
  experiment.qualification.models.multi_point.model.nested_leave_cycle_out.reset();
  const json report = json::parse(to_json(experiment.report()));
  EXPECT_TRUE(report["models"]["multi_point"]["effective_parameters"].is_null());
  EXPECT_TRUE(report["rate_nested_leave_cycle_out"]["multi_point"].is_null());
  EXPECT_TRUE(report["methods"][1]["nested_leave_cycle_out"].is_null());
  EXPECT_TRUE(report["random"]["multi_point"]["expected_in_sample_std_deg_per_h"].is_null());
  EXPECT_TRUE(report["methods"][3]["in_sample"]["std_error_deg_per_h"].is_null());
}

TEST(ReportJson, CitesSourceOfEachMethod) {
  const json methods = json::parse(to_json(SyntheticExperiment().report()))["methods"];
  EXPECT_GE(methods.size(), 4u);
  for (const json& row : methods) {
    EXPECT_NE(row["title"], "") << row["name"];
    EXPECT_NE(row["citation"], "") << row["name"];
    EXPECT_GT(row["stored_numbers"], 0) << row["name"];
  }
}

std::string good_report() {
  static const std::string text = to_json(SyntheticExperiment().report());
  return text;
}

/// The first cluster is an outlier without a residual of one model. Without it, the model does not improve anything.
TEST(Report, ComparesModelsAndRawBiasOnSameClusters) {
  SyntheticExperiment experiment;
  auto& models = experiment.qualification.models;
  const Report before = experiment.report();
  EXPECT_EQ(before.random.raw.count, experiment.random.clusters.start_s.size());
  experiment.random.clusters.bias_deg_per_h(0) += 100;
  models.three_point.random.residual_deg_per_h(0) += 100;
  models.multi_point_t.random.residual_deg_per_h(0) = std::numeric_limits<double>::quiet_NaN();
  const Report report = experiment.report();
  EXPECT_EQ(report.random.raw.count, before.random.raw.count - 1);
  EXPECT_NEAR(report.random.raw.std, before.random.raw.std, 0.05 * before.random.raw.std);
  for (const auto& [found, expected] : {std::pair{report.random.gain.three_point, before.random.gain.three_point},
                                        {report.random.gain.multi_point, before.random.gain.multi_point},
                                        {report.random.gain.multi_point_t, before.random.gain.multi_point_t}}) {
    EXPECT_NEAR(found.from_original, expected.from_original, 0.02);
  }
  EXPECT_NEAR(report.random.gain.multi_point_t.residual_reduction, before.random.gain.multi_point_t.residual_reduction,
              0.02);
}

TEST(ReportFile, ReadsBackWrittenReport) {
  const SyntheticExperiment experiment;
  const auto report = read_report(good_report(), "report.json");
  ASSERT_TRUE(report.has_value()) << text(report.error());
  EXPECT_TRUE(report->rig.is_virtual);
  EXPECT_TRUE(report->rate.in_sample);
  EXPECT_EQ(report->random.residual.multi_point_t.all.std,
            experiment.qualification.models.multi_point_t.random.compensated.std);
  ASSERT_TRUE(report->random.residual.multi_point_t.to_truth);
  EXPECT_EQ(report->random.residual.multi_point_t.to_truth->figures.rmse,
            experiment.qualification.models.multi_point_t.random.to_truth->figures.rmse);
  EXPECT_EQ(report->rate.series.thermometers_c.front().first, "A");
  EXPECT_EQ(report->rate.series.cycles.size(), 4U);
  EXPECT_EQ(report->models.multi_point.support_vectors, 57);
  EXPECT_EQ(report->random.residual.multi_point_t.outside.clusters, 3);
  EXPECT_EQ(report->random.raw.effective.of_std,
            experiment.qualification.models.multi_point.random.raw.effective.of_std);
  EXPECT_EQ(report->rate.noise.holds.curve.size(), experiment.report().rate.noise.holds.curve.size());
  EXPECT_EQ(report->rate.noise.compensated_holds.fit.coefficients.size(), 5U);
  ASSERT_EQ(report->later.size(), 1U);
  EXPECT_EQ(report->later.front().name, "30 days later");
  for (const ReportedMethod& method : report->methods) ASSERT_EQ(method.later.size(), 1U) << method.name;
  const auto& later = report->methods[2].later.front();
  EXPECT_EQ(later.figures.rmse, experiment.qualification.models.multi_point_t.later.front().compensated.rmse);
  EXPECT_EQ(later.coverage->seen, 0.93);
  EXPECT_EQ(report->methods[2].random.coverage->nominal, 0.95);
  ASSERT_TRUE(report->methods[2].between_runs);
  EXPECT_EQ(report->methods[2].between_runs->runs, 2);
  ASSERT_TRUE(report->models.multi_point_t.uncertainty);
  EXPECT_EQ(report->models.multi_point_t.uncertainty->budget.rows[1].of, "A");
  EXPECT_EQ(report->models.multi_point_t.uncertainty->budget.rows[0].degrees_of_freedom, 120);
  ASSERT_TRUE(report->methods[2].uncertainty);
  EXPECT_NEAR(report->methods[2].uncertainty->standard_deg_per_h, 5e-4, 1e-12) << "√(3² + 4²)·10⁻⁴";
  EXPECT_NEAR(report->methods[2].uncertainty->sensitivity_deg_per_h_per_k, 0.01, 1e-12);
  EXPECT_FALSE(report->methods[0].uncertainty) << "the model has no uncertainty budget";
  EXPECT_TRUE(report->methods.back().nested.has_value());
  EXPECT_FALSE(report->methods.front().nested.has_value());
}

TEST(ReportFile, IsWrittenToEqualBytesAfterReading) {
  const auto report = read_report(good_report(), "report.json");
  ASSERT_TRUE(report.has_value()) << text(report.error());
  EXPECT_EQ(to_json(*report), good_report());
}

TEST(ReportFile, ReportsLineAndColumnOfSyntaxError) {
  const auto report = read_report("{\n  \"schema\": ,\n}", "report.json");
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().kind, FaultKind::bad_file);
  EXPECT_EQ(report.error().where, "report.json:2:13");
}

TEST(ReportFile, RefusesOtherSchema) {
  const auto report = read_report(R"({"schema": "gyrotherm-report/2"})", "report.json");
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().kind, FaultKind::bad_file);
  EXPECT_EQ(report.error().where, "report.json: schema");
}

TEST(ReportFile, ReportsEachMissingTopLevelKey) {
  const json whole = json::parse(good_report());
  EXPECT_GT(whole.size(), 10u);
  for (const auto& [key, value] : whole.items()) {
    const bool is_derived = key == "noise_floor_deg_per_h";
    // Reports of 0.1.0 lack this key; a test of ThermalView reads such a report.
    const bool is_later_than_the_schema = key == "thermal";
    if (is_derived || is_later_than_the_schema) continue;
    json less = whole;
    less.erase(key);
    const auto report = read_report(less.dump(), "report.json");
    ASSERT_FALSE(report.has_value()) << key;
    EXPECT_EQ(report.error().kind, FaultKind::bad_file);
    EXPECT_EQ(report.error().where, "report.json: " + key);
  }
}

TEST(ReportFile, ReportsPathOfWrongType) {
  json spoilt = json::parse(good_report());
  spoilt["random"]["multi_point"]["ramps"]["std_deg_per_h"] = "small";
  const auto report = read_report(spoilt.dump(), "report.json");
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().where, "report.json: random.multi_point.ramps.std_deg_per_h");
}

TEST(ReportFile, RefusesColumnOfOtherLength) {
  json spoilt = json::parse(good_report());
  spoilt["series"]["rate"]["multi_point"].push_back(0.1);
  const auto report = read_report(spoilt.dump(), "report.json");
  ASSERT_FALSE(report.has_value());
  EXPECT_EQ(report.error().where, "report.json: series.rate.multi_point");
}

TEST(ReportFile, SurvivesDamagedBytes) {
  const std::string whole = good_report().substr(0, 6000);
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::string damaged = whole;
    for (int k = 0; k < 5; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    const auto report = read_report(damaged, "report.json");
    ASSERT_FALSE(report.has_value());
    EXPECT_EQ(report.error().kind, FaultKind::bad_file);
  }
}

}  // namespace
}  // namespace gyrotherm::report
