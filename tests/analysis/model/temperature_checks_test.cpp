// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/temperature_checks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "analysis/model/training.hpp"

namespace gyrotherm::model {
namespace {

/// Imported record with the thermometer A and one row per 10 s. Records with different ids have different noise.
data::Dataset imported(const std::function<double(double)>& temperature_c, double hours, const char* run_id = "a") {
  const auto rows = static_cast<Eigen::Index>(hours * 360);
  std::mt19937_64 random(static_cast<unsigned char>(*run_id));
  std::normal_distribution<double> normal(0, 0.02), noise(0, 0.16);
  data::Dataset dataset;
  dataset.run_id = run_id;
  dataset.imported = true;
  dataset.thermometers = dataset.gradients = {"A"};
  dataset.bias_zero = "nothing removed";
  dataset.time_s = dataset.moment_s = Eigen::VectorXd::LinSpaced(rows, 0, 10.0 * static_cast<double>(rows - 1));
  dataset.temperature_c.resize(rows, 1);
  dataset.bias_deg_per_h.resize(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double t = temperature_c(dataset.time_s(k) / 3600);
    dataset.temperature_c(k, 0) = t + normal(random);
    dataset.bias_deg_per_h(k) = 5 + 0.05 * t + noise(random);
  }
  dataset.set_point_c.setConstant(rows, std::nan(""));
  dataset.segment.setConstant(rows, -1);
  dataset.cycle.setConstant(rows, -1);
  return dataset;
}

double warm_up(double h) { return 20 + 4 * h; }
double cycle(double h) { return 20 + 20 * std::sin(h); }

Result<Model> train_linear(const std::vector<data::Dataset>& datasets) {
  std::vector<data::Clusters> clusters;
  for (const data::Dataset& dataset : datasets) clusters.push_back(*make_clusters(dataset));
  TrainingOptions options;
  options.method = "linear";
  options.inputs = "temperatures";
  return train(datasets, clusters, options);
}

bool is_called_confused(const Model& model) {
  return std::ranges::any_of(model.warnings, [](const std::string& warning) {
    return warning.find("temperature and time cannot be told apart") != std::string::npos;
  });
}

TEST(TemperatureChecks, DoNotTellDriftFromSingleWarmUp) {
  const auto model = train_linear({imported(warm_up, 8)});
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_TRUE(is_called_confused(*model));
  EXPECT_EQ(model->verdict->gain, Gain::undecided);
  const auto cooling = train_linear({imported([](double h) { return 60 - 4 * h; }, 8)});
  EXPECT_TRUE(is_called_confused(*cooling));
}

TEST(TemperatureChecks, AcceptReturnOfTemperature) {
  const auto model = train_linear({imported(cycle, 12)});
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_FALSE(is_called_confused(*model));
  EXPECT_EQ(model->verdict->gain, Gain::improves);
  const auto one_returns = train_linear({imported(warm_up, 8), imported(cycle, 8, "b")});
  ASSERT_TRUE(one_returns) << text(one_returns.error());
  EXPECT_FALSE(is_called_confused(*one_returns));
  EXPECT_TRUE(is_called_confused(*train_linear({imported(warm_up, 8), imported(warm_up, 8, "b")})));
}

/// After a warm-up with a time constant of 30 min the temperature is constant for hours, in which a drift shows.
TEST(TemperatureChecks, AcceptWarmUpThatEnds) {
  const auto model = train_linear({imported([](double h) { return 60 - 40 * std::exp(-2 * h); }, 12)});
  ASSERT_TRUE(model) << text(model.error());
  EXPECT_FALSE(is_called_confused(*model));
}

TEST(TemperatureChecks, RefuseConstantTemperature) {
  const auto model = train_linear({imported([](double) { return 25.0; }, 8)});
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().kind, FaultKind::usage);
  EXPECT_NE(model.error().what.find("the temperature does not vary"), std::string::npos) << text(model.error());
  const auto slow = train_linear({imported([](double h) { return 25 + 0.05 * std::sin(h); }, 12)});
  EXPECT_TRUE(slow) << "0.05 K is more than the noise of a mean: " << text(slow.error());
}

TEST(TemperatureChecks, RefuseRecordWithoutThermometer) {
  data::Dataset dataset = imported(cycle, 8);
  const auto clusters = *make_clusters(dataset);
  dataset.thermometers.clear();
  TrainingOptions options;
  options.method = "linear";
  const auto model = train({dataset}, {clusters}, options);
  ASSERT_FALSE(model);
  EXPECT_NE(model.error().what.find("has no thermometer"), std::string::npos) << text(model.error());
}

}  // namespace
}  // namespace gyrotherm::model
