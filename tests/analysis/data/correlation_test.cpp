#include "analysis/data/correlation.hpp"

#include <gtest/gtest.h>

#include "tests/analysis/freeimu.hpp"
#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm {
namespace {

const std::vector<std::string> kEight = {"A", "B", "C", "D", "E", "F", "G", "H"};

TEST(Correlation, IsSignedAntisymmetricAndOneForAGradientThatIsTheBias) {
  auto clusters = make_clusters(make_synthetic_run({}));
  ASSERT_TRUE(clusters);
  clusters->bias_deg_per_h = 3 * (clusters->temperature_c.col(1) - clusters->temperature_c.col(0));
  const Correlation r = correlate(*clusters, kEight);
  EXPECT_NEAR(r.gradient(0, 1), -1, 1e-12);
  EXPECT_EQ(r.gradient, -r.gradient.transpose());
  EXPECT_LE(r.gradient.cwiseAbs().maxCoeff(), 1);
}

TEST(Correlation, OfRatesLeavesOutClustersThatHaveNone) {
  Clusters clusters = *make_clusters(make_synthetic_run({}));
  clusters.bias_deg_per_h(0) = 1e6;
  clusters.bias_deg_per_h.tail(clusters.bias_deg_per_h.size() - 1) =
      -2 * clusters.rate_c_per_min.col(3).tail(clusters.bias_deg_per_h.size() - 1);
  EXPECT_NEAR(correlate(clusters, kEight).rate(3), -1, 1e-12);
}

TEST(Correlation, OfARealRecordIsTheReferences) {
  const double with_die[] = {-0.9148, 0.9996, -0.9534}, with_difference[] = {0.9456, -0.8873, 0.8487};
  for (const FreeImuAxis axis : {FreeImuAxis::x, FreeImuAxis::y, FreeImuAxis::z}) {
    const auto dataset = load_freeimu(axis);
    if (!dataset) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
    const Correlation r = correlate(*make_clusters(*dataset), dataset->gradients);
    EXPECT_NEAR(r.temperature(0), with_die[static_cast<int>(axis)], 5e-5);
    EXPECT_NEAR(r.gradient(0, 1), with_difference[static_cast<int>(axis)], 5e-5);
  }
}

}  // namespace
}  // namespace gyrotherm
