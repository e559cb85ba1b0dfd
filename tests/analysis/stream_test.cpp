#include "analysis/stream.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "small_model.hpp"

namespace gyrotherm {
namespace {

/// Both thermometers on ramps, A the faster.
Dataset two_ramps(Eigen::Index rows) {
  Dataset dataset;
  dataset.thermometers = {"A", "B"};
  dataset.time_s = Eigen::VectorXd::LinSpaced(rows, 0, static_cast<double>(rows - 1));
  dataset.temperature_c.resize(rows, 2);
  dataset.temperature_c << 20 + 2e-3 * dataset.time_s.array(), 20 + 1e-3 * dataset.time_s.array();
  dataset.bias_deg_per_h = Eigen::VectorXd::Constant(rows, 0.5);
  dataset.set_point_c = dataset.temperature_c.col(0);
  dataset.segment.setConstant(rows, -1);
  dataset.cycle.setConstant(rows, -1);
  return dataset;
}

TEST(CompensationStream, IsThePredictionOnClustersAtTheirEnds) {
  const Dataset dataset = two_ramps(1000);
  const Clusters clusters = *make_clusters(dataset);
  const Eigen::VectorXd predicted = *predict(small_svr_model(), clusters);
  auto stream = CompensationStream::open(small_svr_model(), {"A", "B"});
  ASSERT_TRUE(stream);
  for (Eigen::Index i = 0; i < 1000; ++i) {
    const double compensated = stream->push({dataset.temperature_c(i, 0), dataset.temperature_c(i, 1)}, 0.5);
    EXPECT_EQ(std::isnan(compensated), i < 199) << "a rate needs two means, row " << i;
    if (i >= 199 && i % 100 == 99) {
      EXPECT_NEAR(compensated, 0.5 - predicted(i / 100), 1e-12);
    }
  }
}

TEST(CompensationStream, TakesColumnsInAnyOrder) {
  auto stream = CompensationStream::open(small_svr_model(), {"shell", "B", "A"});
  auto same = CompensationStream::open(small_svr_model(), {"A", "B"});
  double one = 0, other = 1;
  for (int i = 0; i < 200; ++i) {
    one = stream->push({i + 7.0, 19.5, 20.0 + 0.001 * i}, 0);
    other = same->push({20.0 + 0.001 * i, 19.5}, 0);
  }
  EXPECT_EQ(one, other);
}

TEST(CompensationStream, RecoversFromAMissingReading) {
  auto stream = CompensationStream::open(small_svr_model(), {"A", "B"});
  double last = 0;
  for (int i = 0; i < 250; ++i) last = stream->push({i == 30 ? std::nan("") : 20.0, 19.0}, 0);
  EXPECT_FALSE(std::isnan(last));
  last = stream->push({std::nan(""), 19.0}, 0);
  EXPECT_TRUE(std::isnan(last));
}

TEST(CompensationStream, NeedsTheModelsThermometers) {
  EXPECT_EQ(CompensationStream::open(small_svr_model(), {"A", "C"}).error().kind, FaultKind::usage);
}

}  // namespace
}  // namespace gyrotherm
