// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/power_on_constants.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "analysis/model/training.hpp"
#include "analysis/model/verification.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::model {
namespace {

using data::Clusters;
using data::Dataset;

/// Returns clusters in which each of four cycles follows a power-on of its own with the given constant, °/h.
Clusters with_power_ons(const Dataset& dataset, const Eigen::Vector4d& constants) {
  Clusters clusters = *make_clusters(dataset);
  clusters.power_on = clusters.cycle.cwiseMax(0);
  for (Eigen::Index k = 0; k < clusters.power_on.size(); ++k)
    clusters.bias_deg_per_h(k) += constants(clusters.power_on(k));
  return clusters;
}

PowerOnRule rule_for(const Dataset& dataset, double repeatability) {
  PowerOnRule rule = power_on_rule(dataset);
  rule.repeatability_deg_per_h = repeatability;
  return rule;
}

Eigen::Vector4d of_power_ons(const Clusters& clusters, const Eigen::VectorXd& constants) {
  Eigen::Vector4d found;
  for (Eigen::Index k = 0; k < constants.size(); ++k) found(clusters.power_on(k)) = constants(k);
  return found;
}

TrainingOptions on_temperatures(const char* method) {
  TrainingOptions options;
  options.inputs = "temperatures";
  options.method = method;
  options.quick = true;
  return options;
}

TEST(PowerOnConstants, AreThoseOfTheRecordLessTheirMean) {
  const Dataset dataset = data::make_synthetic_run({});
  const Eigen::Vector4d put_in{0.03, -0.05, 0.01, 0.02};
  const Clusters clusters = with_power_ons(dataset, put_in);
  const auto constants = power_on_constants(clusters, rule_for(dataset, 0.05));
  ASSERT_TRUE(constants) << constants.error().what;
  const Eigen::Vector4d found = of_power_ons(clusters, *constants);
  EXPECT_NEAR(found.sum(), 0, 1e-9);
  const Eigen::Vector4d expected = put_in.array() - put_in.mean();
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 0.003) << found.transpose();
}

TEST(PowerOnConstants, AreNearZeroIfTheRepeatabilityIsFarBelowTheNoise) {
  const Dataset dataset = data::make_synthetic_run({});
  const Clusters clusters = with_power_ons(dataset, {0.03, -0.05, 0.01, 0.02});
  const auto constants = power_on_constants(clusters, rule_for(dataset, 1e-6));
  ASSERT_TRUE(constants);
  EXPECT_LT(constants->cwiseAbs().maxCoeff(), 1e-4);
}

TEST(PowerOnConstants, OfAShortPowerOnIsSmaller) {
  const Dataset dataset = data::make_synthetic_run({.noise_deg_per_h = 2});
  Clusters clusters = *make_clusters(dataset);
  clusters.power_on.setZero(clusters.start_s.size());
  clusters.power_on.tail(2).setOnes();  // two clusters
  clusters.bias_deg_per_h.tail(2).array() += 0.5;
  const auto constants = power_on_constants(clusters, rule_for(dataset, 0.05));
  ASSERT_TRUE(constants);
  EXPECT_GT((*constants)(constants->size() - 1), 0);
  EXPECT_LT((*constants)(constants->size() - 1), 0.1);
}

TEST(PowerOnConstants, AreZeroForASinglePowerOn) {
  const Dataset dataset = data::make_synthetic_run({});
  Clusters clusters = *make_clusters(dataset);
  EXPECT_EQ(power_on_constants(clusters, power_on_rule(dataset))->cwiseAbs().maxCoeff(), 0);
  clusters.power_on.resize(0);  // unknown
  EXPECT_EQ(power_on_constants(clusters, power_on_rule(dataset))->cwiseAbs().maxCoeff(), 0);
  EXPECT_TRUE(list_power_ons(clusters, Eigen::VectorXd::Zero(clusters.start_s.size())).empty());
}

TEST(PowerOnConstants, AreZeroWithoutAThermometerOrARepeatability) {
  Dataset dataset = data::make_synthetic_run({});
  const Clusters clusters = with_power_ons(dataset, {0.03, -0.05, 0.01, 0.02});
  EXPECT_EQ(power_on_constants(clusters, rule_for(dataset, 0))->cwiseAbs().maxCoeff(), 0);
  dataset.gradients.clear();
  EXPECT_EQ(power_on_constants(clusters, rule_for(dataset, 0.05))->cwiseAbs().maxCoeff(), 0);
}

TEST(PowerOnConstants, LeaveTheEffectOfTheTemperatures) {
  // Power-ons at different temperatures: a free constant for each would take the slope for constants.
  const Dataset dataset = data::make_synthetic_run({.absolute_deg_per_h_per_c = 0.01});
  Clusters clusters = *make_clusters(dataset);
  const Eigen::Index count = clusters.start_s.size();
  for (Eigen::Index k = 0; k < count; ++k) clusters.power_on(k) = clusters.temperature_c.row(k).mean() > 20 ? 1 : 0;
  const auto constants = power_on_constants(clusters, rule_for(dataset, 0.001));
  ASSERT_TRUE(constants);
  EXPECT_LT(constants->cwiseAbs().maxCoeff(), 0.002);
}

TEST(PowerOnConstants, GiveTheModelOfARecordWithoutConstants) {
  Dataset dataset = data::make_synthetic_run({});
  dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h = 0.05;
  const Eigen::Vector4d put_in{0.06, -0.1, 0.02, 0.02};  // mean 0
  const Clusters without = *make_clusters(dataset);
  const Clusters with = with_power_ons(dataset, put_in);
  for (const char* method : {"ridge-u", "linear", "gp", "svr-linear"}) {
    SCOPED_TRACE(method);
    const TrainingOptions options = on_temperatures(method);
    const auto reference = train({dataset}, {without}, options), model = train({dataset}, {with}, options);
    ASSERT_TRUE(reference && model);
    const Eigen::VectorXd difference = *predict(*model, without) - *predict(*reference, without);
    EXPECT_LT(std::sqrt(difference.squaredNorm() / static_cast<double>(difference.size())), 0.01);
    ASSERT_EQ(model->power_ons.size(), 4u);
    EXPECT_TRUE(reference->power_ons.empty());
    // The constants are a row of their own, not model form.
    const auto row_of = [](const Model& of, Source source) {
      return *std::ranges::find(of.uncertainty->budget.rows, source, &BudgetRow::source);
    };
    EXPECT_DOUBLE_EQ(row_of(*model, Source::turn_on).sensitivity, std::sqrt(1.25));
    EXPECT_DOUBLE_EQ(row_of(*reference, Source::turn_on).sensitivity, std::sqrt(2));
    EXPECT_FALSE(row_of(*model, Source::model_form).only_start_held_out);
    EXPECT_LT(row_of(*model, Source::model_form).standard_uncertainty, 0.05);
  }
}

TEST(PowerOnConstants, OfTheModelAreStored) {
  Dataset dataset = data::make_synthetic_run({});
  dataset.gyro_uncertainty.turn_on_repeatability_deg_per_h = 0.05;
  const auto model = train({dataset}, {with_power_ons(dataset, {0.06, -0.1, 0.02, 0.02})}, on_temperatures("ridge-u"));
  ASSERT_TRUE(model);
  const auto read = model_from_json(to_json(*model), "model.json");
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->power_ons.size(), 4u);
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(read->power_ons[s].clusters, model->power_ons[s].clusters);
    EXPECT_EQ(read->power_ons[s].constant_deg_per_h, model->power_ons[s].constant_deg_per_h);
  }
}

TEST(PowerOnConstants, BeyondTheRepeatabilityAreWarnedAbout) {
  const std::vector<PowerOn> calm{{100, 0.001}, {100, -0.0005}, {100, -0.0005}};
  EXPECT_EQ(describe_scatter(calm, 0.001), "");
  const std::vector<PowerOn> wild{{100, 0.02}, {100, -0.01}, {100, -0.01}};
  EXPECT_NE(describe_scatter(wild, 0.001).find("3 power-ons have a standard deviation of 0.017 °/h"), std::string::npos)
      << describe_scatter(wild, 0.001);
  EXPECT_EQ(describe_scatter(wild, 0), "");
  EXPECT_EQ(describe_scatter({{100, 1.0}}, 0.001), "");
}

}  // namespace
}  // namespace gyrotherm::model
