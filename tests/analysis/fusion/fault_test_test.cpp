// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/fault_test.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "analysis/data/distributions.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "tests/analysis/fusion/fixtures.hpp"

namespace gyrotherm::fusion {
namespace {

/// Axes with the parity test for them.
struct TestedAxes {
  explicit TestedAxes(const std::vector<InputAxis>& axes)
      : geometry(valid_geometry(axes)), gains(compute_gains(geometry)), test(parity_test(gains, geometry)) {}
  /// Tests drawn readings with an additional bias of one axis, °/h. An axis of −1 adds none.
  [[nodiscard]] Finding find(Draws& draws, Eigen::Index axis, double bias, const TestOptions& options) const {
    Eigen::VectorXd readings = draws.correlated_normal(geometry.covariance);
    if (axis >= 0) readings(axis) += bias;
    return examine(test, gains.parity * readings, options);
  }
  Geometry geometry;
  Gains gains;
  FaultTest test;
};

/// 20 seeds of 2000 readings each, 40 000 in total. A relative frequency deviates from its expectation by more than
/// four standard deviations with a probability of 1/16 000.
constexpr int kReadingsOfSeed = 2000;

TEST(FaultTest, HasStatedFalseAlarmProbability) {
  for (const auto& axes : {tetrad_axes(0.01), dodecahedron_axes(0.01), uneven_axes()}) {
    const TestedAxes tested(axes);
    for (const double probability : {0.05, 0.003}) {
      int alarms = 0;
      for (int seed = 1; seed <= kSeeds; ++seed) {
        Draws draws(static_cast<std::uint64_t>(seed));
        for (int n = 0; n < kReadingsOfSeed; ++n)
          alarms += tested.find(draws, -1, 0, {.false_alarm_probability = probability}).fault ? 1 : 0;
      }
      constexpr double kCount = kSeeds * kReadingsOfSeed;
      EXPECT_NEAR(alarms / kCount, probability, 4 * relative_frequency_std(probability, kCount))
          << axes.size() << " axes";
    }
  }
}

TEST(FaultTest, HasDetectionProbabilityOfNoncentralChiSquared) {
  for (const auto& axes : {tetrad_axes(0.01), dodecahedron_axes(0.01), uneven_axes()}) {
    const TestedAxes tested(axes);
    constexpr double kFalse = 0.001, kCount = kSeeds * kReadingsOfSeed;
    for (const double wanted : {0.2, 0.9}) {
      const Eigen::Index hopped = 1;
      const double size = detectable_size(tested.test, hopped, wanted, kFalse);
      int found = 0;
      for (int seed = 1; seed <= kSeeds; ++seed) {
        Draws draws(static_cast<std::uint64_t>(seed));
        for (int n = 0; n < kReadingsOfSeed; ++n)
          found += tested.find(draws, hopped, size, {.false_alarm_probability = kFalse}).fault ? 1 : 0;
      }
      EXPECT_NEAR(detection_probability(tested.test, hopped, size, kFalse), wanted, 1e-9);
      EXPECT_NEAR(found / kCount, wanted, 4 * relative_frequency_std(wanted, kCount)) << axes.size() << " axes";
    }
  }
}

/// Computes the probability that the first of six effects (unit vectors f₁ … f₆ in space) is the likeliest one for a
/// parity vector distributed as N(δ f₁, I). Integrates the shifted normal density along the radius in closed form and
/// over the directions on a grid of the sphere.
double correct_identification_probability(const FaultTest& test, double delta) {
  Eigen::MatrixXd effects = test.effects.colwise().normalized();
  const Eigen::Vector3d shift = delta * effects.col(0);
  constexpr int kHeights = 400, kTurns = 800;
  double share = 0;
  for (int i = 0; i < kHeights; ++i) {
    const double z = -1 + 2 * (i + 0.5) / kHeights;
    for (int j = 0; j < kTurns; ++j) {
      const double turn = 2 * std::numbers::pi * (j + 0.5) / kTurns, radius = std::sqrt(1 - z * z);
      const Eigen::Vector3d direction(radius * std::cos(turn), radius * std::sin(turn), z);
      Eigen::Index best{};
      (effects.transpose() * direction).cwiseAbs().maxCoeff(&best);
      if (best != 0) continue;
      // ∫ r² exp(−(r² − 2 r c + δ²)/2) dr from 0, with c the component of the shift along the direction.
      const double c = shift.dot(direction);
      const double normal = std::sqrt(std::numbers::pi / 2) * std::erfc(-c / std::numbers::sqrt2);
      share += std::exp((c * c - delta * delta) / 2) * (1 + c * c) * normal + c * std::exp(-delta * delta / 2);
    }
  }
  return share * 4 * std::numbers::pi / (kHeights * kTurns) / std::pow(2 * std::numbers::pi, 1.5);
}

TEST(FaultTest, IdentifiesAxisOfDodecahedronWithTheoreticalProbability) {
  const double u = 0.01;
  const TestedAxes tested(dodecahedron_axes(u));
  EXPECT_NEAR(tested.test.effects.col(0).norm(), std::sqrt(0.5) / u, 1e-9)
      << "the parity contains half of the square of a bias";
  EXPECT_NEAR(correct_identification_probability(tested.test, 0), 1.0 / 6, 1e-3)
      << "without a fault all axes are equally likely";
  constexpr double kCount = kSeeds * kReadingsOfSeed;
  for (const double delta : {1.0, 2.5, 4.0}) {
    const double expected = correct_identification_probability(tested.test, delta);
    int right = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      Draws draws(static_cast<std::uint64_t>(seed));
      for (int n = 0; n < kReadingsOfSeed; ++n) {
        const Finding finding =
            tested.find(draws, 0, delta * u * std::numbers::sqrt2, {.false_alarm_probability = 1 - 1e-12});
        right += finding.isolation->likeliest == 0 ? 1 : 0;
      }
    }
    EXPECT_NEAR(right / kCount, expected, 4 * relative_frequency_std(expected, kCount) + 1e-3) << delta;
  }
}

TEST(FaultTest, MisidentifiesAxisLessOftenThanMarginAllows) {
  const double u = 0.01;
  const TestedAxes tested(dodecahedron_axes(u));
  int named = 0, wrong = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    for (int n = 0; n < kReadingsOfSeed; ++n) {
      const Finding finding = tested.find(draws, n % 6, 8 * u, {.false_alarm_probability = 1e-4});
      if (!finding.isolation || !finding.isolation->candidate) continue;
      ++named;
      wrong += *finding.isolation->candidate == n % 6 ? 0 : 1;
    }
  }
  EXPECT_GT(named, 0.8 * kSeeds * kReadingsOfSeed);
  EXPECT_LT(wrong, 5.0 / 20 * named / 6) << "the five other axes are each 20 times less likely";
}

TEST(FaultTest, EstimatesSizeOfFault) {
  const double u = 0.01;
  const TestedAxes tested(dodecahedron_axes(u));
  Draws draws(1);
  double squares = 0;
  constexpr int kCount = 4000;
  for (int n = 0; n < kCount; ++n) {
    const Finding finding = tested.find(draws, 2, 0.15, {});
    ASSERT_TRUE(finding.isolation && finding.isolation->candidate);
    EXPECT_EQ(*finding.isolation->candidate, 2);
    EXPECT_NEAR(finding.isolation->size_std, u * std::numbers::sqrt2, 1e-12);
    squares += std::pow((finding.isolation->size - 0.15) / finding.isolation->size_std, 2) / kCount;
  }
  EXPECT_NEAR(squares, 1, 4 * std::sqrt(2.0 / kCount));
}

TEST(FaultTest, DetectsWithoutIsolationForFourAxes) {
  const TestedAxes tested(tetrad_axes(0.01));
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Draws draws(static_cast<std::uint64_t>(seed));
    const Finding finding = tested.find(draws, seed % 4, 1, {});
    EXPECT_TRUE(finding.fault);
    ASSERT_TRUE(finding.isolation);
    EXPECT_FALSE(finding.isolation->candidate);
    EXPECT_EQ(finding.isolation->rivals.size(), 3u);
    EXPECT_NEAR(finding.isolation->margin, 0, 1e-6 * finding.statistic);
    EXPECT_TRUE(finding.isolation->explains);
  }
}

TEST(FaultTest, FindsNothingForThreeAxes) {
  const TestedAxes tested(triad_axes(0.01));
  Draws draws(1);
  const Finding finding = tested.find(draws, 0, 1000, {});
  EXPECT_FALSE(finding.fault);
  EXPECT_EQ(finding.freedom, 0);
  EXPECT_EQ(detectable_size(tested.test, 0, 0.9, 0.01), std::numeric_limits<double>::infinity());
}

TEST(FaultTest, CannotDetectFaultOfAxisWithoutRedundancy) {
  const TestedAxes tested(
      {axis("1", 1, 0, 0, 1), axis("2", 0, 1, 0, 1), axis("3", 1, 1, 0, 1), axis("up", 0, 0, 1, 1)});
  Draws draws(1);
  EXPECT_FALSE(tested.find(draws, 3, 1000, {}).fault);
  EXPECT_EQ(detectable_size(tested.test, 3, 0.9, 0.01), std::numeric_limits<double>::infinity());
  const Finding finding = tested.find(draws, 0, 1000, {});
  ASSERT_TRUE(finding.isolation);
  EXPECT_EQ(finding.isolation->rivals.size(), 2u) << "an axis without redundancy is not a candidate";
}

TEST(FaultTest, ReportsThatTwoFaultsAreNotOneFault) {
  const TestedAxes tested(dodecahedron_axes(0.01));
  Draws draws(1);
  Eigen::VectorXd readings = draws.correlated_normal(tested.geometry.covariance);
  readings(0) += 0.5;
  readings(3) += 0.4;
  const Finding finding = examine(tested.test, tested.gains.parity * readings);
  ASSERT_TRUE(finding.fault && finding.isolation);
  EXPECT_FALSE(finding.isolation->explains);
  EXPECT_FALSE(finding.isolation->candidate);
}

}  // namespace
}  // namespace gyrotherm::fusion
