// SPDX-License-Identifier: Apache-2.0
#include "report/draft.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "analysis/data/dataset.hpp"
#include "report/order.hpp"
#include "tests/support/sample_calibration.hpp"

namespace gyrotherm::report {
namespace {

DraftSources sample_sources() {
  return {.program_version = "0.2.0",
          .calibration_sha256 = std::string(64, 'a'),
          .unit = "u1",
          .records = {"../rate.db", "../a b/\"random\".db"},
          .models_left = {"../x.json"},
          .laboratory = "../laboratory.toml",
          .order = "../order.toml",
          .unverified = true};
}

TEST(DraftSources, AreReadAsWritten) {
  const std::string json = to_json(sample_sources());
  const auto read = draft_sources_from_json(json, "sources.json");
  ASSERT_TRUE(read) << text(read.error());
  EXPECT_EQ(to_json(*read), json);
  EXPECT_EQ(read->records, sample_sources().records);
  EXPECT_TRUE(read->unverified);
}

TEST(DraftSources, RefuseOtherDocuments) {
  const std::string json = to_json(sample_sources());
  std::string other_schema = json, without_records = json;
  other_schema.replace(other_schema.find("sources/1"), 9, "sources/2");
  without_records.replace(without_records.find("\"records\""), 9, "\"recordz\"");
  for (const std::string& wrong : {std::string(), std::string("[]"), other_schema, without_records, json.substr(1)}) {
    const auto read = draft_sources_from_json(wrong, "sources.json");
    ASSERT_FALSE(read) << wrong;
    EXPECT_EQ(read.error().kind, FaultKind::bad_file);
  }
}

TEST(ChangedKeys, NameEachDifferentValue) {
  const auto changed = [](const char* before, const char* now) { return find_changed_keys(before, now).value(); };
  EXPECT_TRUE(changed(R"({"a": 1.0, "b": [1, null]})", R"({"b": [1, null], "a": 1})").empty());
  EXPECT_EQ(changed(R"({"a": true, "b": [1, 2]})", R"({"a": false, "b": [1, 3]})"),
            (std::vector<std::string>{"a", "b/1"}));
  EXPECT_EQ(changed(R"({"a": 1})", R"({"a": 1, "c": 2})"), std::vector<std::string>{"c"});
  EXPECT_EQ(changed(R"({"a": [1, 2]})", R"({"a": [1]})"), std::vector<std::string>{"a/1"});
  EXPECT_FALSE(find_changed_keys("{", "{}"));
}

/// Returns a report without the budgets of the sample, which are not those of its means.
CalibrationReport consistent_sample() {
  CalibrationReport report = sample_calibration();
  report.budgets.clear();
  return report;
}

TEST(Contradictions, AreAbsentFromConsistentReport) {
  EXPECT_EQ(find_contradictions(consistent_sample()), std::vector<std::string>{});
}

/// Gives the report the limit by this rule, as an order does, and a zero that is its own first hold.
TEST(Contradictions, AreAbsentFromReportWithUnknownZero) {
  for (const DecisionRule rule : {DecisionRule::simple, DecisionRule::guard_band})
    for (const char* quantity : {"stabilised_bias.bias", "compensated_mean.compensated_bias", "whole_run.rmse"})
      for (const double at_most : {1e-9, 1e9}) {
        CalibrationReport report = consistent_sample();
        report.conformity.clear();
        report.bias_zero = data::kOwnReference;
        apply_limits(report, {{.quantity = quantity, .at_most = at_most}}, rule);
        EXPECT_EQ(report.conformity.front().verdict, Verdict::not_known);
        EXPECT_EQ(find_contradictions(report), std::vector<std::string>{}) << quantity;
        report.conformity.front().verdict = Verdict::pass;
        EXPECT_FALSE(find_contradictions(report).empty()) << quantity;
      }
}

/// Each change makes a report whose numbers and verdicts do not belong together.
TEST(Contradictions, AreFoundInFalsifiedReport) {
  const std::vector<std::function<void(CalibrationReport&)>> changes{
      [](auto& report) { report.conformity.front().verdict = Verdict::pass; },
      [](auto& report) { report.conformity.front().probability = 0.999; },
      [](auto& report) { report.conformity.front().value.value /= 2; },
      [](auto& report) { report.conformity.front().value.standard_uncertainty /= 10; },
      [](auto& report) { report.conformity.front().limit *= 1000; },
      [](auto& report) { report.conformity.front().axis = "u1.z"; },
      [](auto& report) { report.conformity.front().rule = DecisionRule::simple; },
      [](auto& report) { report.rule = DecisionRule::simple; },
      [](auto& report) { report.conformity.erase(report.conformity.begin()); },
      [](auto& report) {
        for (ResultTable& table : report.results)
          if (table.key == "compensated_mean") table.columns.front().values.front().value = 0.00001;
      },
      [](auto& report) {
        std::erase_if(report.results, [](const ResultTable& table) { return table.key == "compensated_mean"; });
      }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    CalibrationReport report = consistent_sample();
    changes[i](report);
    EXPECT_FALSE(find_contradictions(report).empty()) << i;
  }
}

TEST(Contradictions, IncludeBudgetOfAnotherMean) {
  CalibrationReport report = sample_calibration();
  const auto mean = std::ranges::find(report.results, "compensated_mean", &ResultTable::key);
  ASSERT_NE(mean, report.results.end());
  report.conformity.clear();
  report.budgets = {{.axis = mean->axis,
                     .stage = mean->stage,
                     .run = mean->run,
                     .budget = {.averaging_s = 3600, .rows = {{.standard_uncertainty = 7, .sensitivity = 1}}}}};
  EXPECT_EQ(find_contradictions(report).size(), 1U);
  const model::CombinedUncertainty all = combined(report.budgets.front().budget.rows);
  mean->columns.front().values.front().standard_uncertainty = all.standard_deg_per_h;
  mean->columns.front().values.front().coverage_factor = all.coverage_factor;
  EXPECT_TRUE(find_contradictions(report).empty());
}

}  // namespace
}  // namespace gyrotherm::report
