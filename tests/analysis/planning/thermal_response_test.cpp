// SPDX-License-Identifier: Apache-2.0
#include "analysis/planning/thermal_response.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::planning {
namespace {

TEST(ThermalResponse, PredictsAnotherProgram) {
  const data::Dataset learnt = data::make_synthetic_run({}),
                      other = data::make_synthetic_run({.cycle_rates_c_per_min = {1, 5}, .hold_s = 4000});
  const auto response = fit_response(learnt);
  ASSERT_TRUE(response) << response.error().what;
  EXPECT_LT(response->rms_k, 0.5);
  const Eigen::MatrixXd predicted = predict_temperatures(*response, recorded_path(other));
  const data::Clusters clusters = *make_clusters(other);
  const Eigen::Index count = std::min(predicted.rows(), clusters.temperature_c.rows());
  const Eigen::MatrixXd difference = predicted.topRows(count) - clusters.temperature_c.topRows(count);
  EXPECT_LT(std::sqrt(difference.squaredNorm() / static_cast<double>(difference.size())), 0.7);
}

TEST(ThermalResponse, StaysTypicalWhereARecordSaysLittle) {
  data::Dataset hour = data::make_synthetic_run({});
  const Eigen::Index rows = 1000;  // rows of the first hold
  hour.time_s.conservativeResize(rows);
  hour.temperature_c.conservativeResize(rows, Eigen::NoChange);
  hour.set_point_c.conservativeResize(rows);
  hour.segment.conservativeResize(rows);
  const auto response = fit_response(hour);
  ASSERT_TRUE(response);
  const ThermalResponse typical = typical_response(hour.gradients);
  EXPECT_LT((response->gain - typical.gain).cwiseAbs().maxCoeff(), 0.2);
  EXPECT_LT((response->gain.colwise().sum().array() - 1).abs().maxCoeff(), 0.05);
}

TEST(ThermalResponse, StartsInEquilibrium) {
  const ThermalResponse typical = typical_response({"A", "B"});
  ProgramPath path;
  path.set_point_c.setConstant(20, -40);
  path.start.setZero(20);
  const Eigen::MatrixXd predicted = predict_temperatures(typical, path);
  EXPECT_LT((predicted.array() - predicted(0, 0)).abs().maxCoeff(), 1e-9);
  EXPECT_NEAR(predicted(0, 0), -35, 1e-9) << "5 K above the air";
}

TEST(ThermalResponse, CoolsAUnitThatIsOff) {
  const ThermalResponse typical = typical_response({"A"});
  ProgramPath path;
  path.set_point_c.setConstant(600, 20);
  path.start.setConstant(600, -1);
  path.start(0) = 0;
  EXPECT_NEAR(predict_temperatures(typical, path)(599, 0), 20, 0.1);
}

TEST(ThermalResponse, GivesClustersOnlyWhileTheUnitIsOn) {
  const ThermalResponse typical = typical_response({"A", "B"});
  ProgramPath path;
  path.set_point_c = (Eigen::VectorXd(5) << 20, 30, 40, 40, 40).finished();
  path.start = (Eigen::VectorXi(5) << 0, 0, -1, 1, 1).finished();
  const data::Clusters clusters = predict_clusters(typical, path, 1);
  EXPECT_EQ(clusters.start_s, Eigen::Vector3d(100, 300, 400));
  EXPECT_EQ(clusters.power_on, Eigen::Vector3i(0, 1, 1));
  ASSERT_TRUE(has_history(clusters));
  EXPECT_EQ(clusters.history.temperature_c.rows(), 5);
  EXPECT_NEAR(clusters.rate_c_per_min(0, 0),
              0.6 * (clusters.history.temperature_c(1, 0) - clusters.history.temperature_c(0, 0)), 1e-12);
}

TEST(ThermalResponse, NeedsThermometersAndSetPoints) {
  data::Dataset dataset = data::make_synthetic_run({});
  dataset.set_point_c.setConstant(std::nan(""));  // imported
  EXPECT_EQ(fit_response(dataset).error().kind, FaultKind::usage);
  dataset = data::make_synthetic_run({});
  dataset.gradients.clear();
  EXPECT_EQ(fit_response(dataset).error().kind, FaultKind::usage);
  EXPECT_FALSE(fit_response({}));
}

}  // namespace
}  // namespace gyrotherm::planning
