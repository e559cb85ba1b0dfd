// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/inputs.hpp"

#include <gtest/gtest.h>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

std::size_t fixed(const std::string& inputs) { return plan_inputs(inputs, data::make_synthetic_run({}))->fixed.size(); }

TEST(Inputs, ParsesKeywordsAndTermsInAnyMix) {
  EXPECT_EQ(fixed("gradients"), 28u);
  EXPECT_EQ(fixed("temperatures"), 8u);
  EXPECT_EQ(fixed("rates"), 8u);
  EXPECT_EQ(fixed("three-point"), 3u);
  EXPECT_EQ(fixed("three-point-t"), 4u);
  EXPECT_EQ(fixed("thermal-history"), 48u) << "8 temperatures, 16 lags, and the product of T with each";
  EXPECT_EQ(fixed("thermal-history,lag:600:A,A^2"), 48u);
  EXPECT_EQ(fixed("gradients,temperatures,rates"), 44u);
  EXPECT_EQ(fixed("gradients+temperatures + rates, A^2"), 45u);
  EXPECT_EQ(fixed("seven-point,three-point,A-B"), 8u) << "A-D, A-G and A-B are in both sets";
}

TEST(Inputs, SelectsFromKeywordsAndKeepsSingleTerms) {
  const data::Dataset dataset = data::make_synthetic_run({});
  const InputPlan plan = *plan_inputs("gradients,A,A-B", dataset, *parse_selection("forward"));
  EXPECT_EQ(plan.fixed, (std::vector<data::Term>{data::temperature_term("A"), data::gradient_term("A", "B")}));
  EXPECT_EQ(plan.candidates.size(), 27u) << "A-B is selected in any case";
  EXPECT_EQ(plan.rule.kind, SelectionKind::forward);
  EXPECT_EQ(plan_inputs("A,A-B", dataset, SelectionRule{}).error().where, "--select");
}

TEST(Inputs, SelectsByCorrelationForMultiPoint) {
  const data::Dataset dataset = data::make_synthetic_run({});
  const InputPlan plan = *plan_inputs("multi-point-t", dataset);
  EXPECT_EQ(plan.candidates.size(), 28u);
  EXPECT_EQ(plan.fixed, std::vector<data::Term>{data::temperature_term("A")});
  EXPECT_EQ(plan.rule.kind, SelectionKind::correlation);
  EXPECT_EQ(plan.rule.threshold, 0.90);
  EXPECT_EQ(plan_inputs("multi-point", dataset, *parse_selection("redundancy"))->rule.kind, SelectionKind::redundancy);
}

TEST(Inputs, AcceptsPlusInThermometerName) {
  data::Dataset dataset = data::make_synthetic_run({});
  dataset.thermometers.front() = "T+";
  dataset.gradients = dataset.thermometers;
  EXPECT_EQ(plan_inputs("T+,B", dataset)->fixed,
            (std::vector<data::Term>{data::temperature_term("T+"), data::temperature_term("B")}));
  EXPECT_EQ(plan_inputs("B+C", dataset)->fixed.size(), 2u);
}

TEST(Inputs, ReportsInvalidInput) {
  const data::Dataset dataset = data::make_synthetic_run({});
  EXPECT_NE(plan_inputs("gradient", dataset).error().what.find("\"gradients\""), std::string::npos);
  EXPECT_FALSE(plan_inputs("A,A", dataset));
  EXPECT_FALSE(plan_inputs("gradients,,A", dataset));
  data::Dataset one = dataset;
  one.gradients = {"A"};
  EXPECT_FALSE(plan_inputs("gradients", one));
  EXPECT_TRUE(plan_inputs("temperatures", one));
}

TEST(Inputs, HasNoRateInFirstClusterOfRun) {
  const data::Dataset dataset = data::make_synthetic_run({});
  const data::Clusters clusters = *make_clusters(dataset);
  const auto rows = rows_with_inputs(*plan_inputs("A,rate:A", dataset), clusters);
  ASSERT_TRUE(rows);
  EXPECT_EQ(static_cast<Eigen::Index>(rows->size()), clusters.start_s.size() - 1);
  EXPECT_EQ(rows->front(), 1);
  EXPECT_EQ(rows_with_inputs(*plan_inputs("A", dataset), clusters)->front(), 0);
}

}  // namespace
}  // namespace gyrotherm::model
