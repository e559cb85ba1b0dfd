#include "analysis/data/allan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/analysis/data/simulated_noise.hpp"

namespace gyrotherm {
namespace {

/// The 1000 points of NIST SP 1065, section 12.4.
Eigen::VectorXd nist_values() {
  Eigen::VectorXd values(1000);
  std::int64_t n = 1234567890;
  for (double& value : values) {
    value = static_cast<double>(n) / 2147483647.0;
    n = 16807 * n % 2147483647;
  }
  return values;
}

TEST(AllanDeviation, IsTheNistReference) {
  const Eigen::VectorXd values = nist_values();
  EXPECT_NEAR(values(0), 0.5748904732, 5e-11);
  EXPECT_NEAR(values(999), 0.7264947764, 5e-11);
  EXPECT_NEAR(values.mean(), 0.4897745, 5e-8);
  EXPECT_NEAR(overlapping_allan_deviation(values, 1), 2.922319e-01, 5e-8);
  EXPECT_NEAR(overlapping_allan_deviation(values, 10), 9.159953e-02, 5e-9);
  EXPECT_NEAR(overlapping_allan_deviation(values, 100), 3.241343e-02, 5e-9);
}

TEST(AllanDeviation, IsTheMeanSquareDifferenceOfNeighbouringMeans) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const Eigen::Index count = 40 + static_cast<Eigen::Index>(random() % 100);
    const Eigen::VectorXd values = simulate({.N = 1, .K = 3}, count, 60, random);
    const int m = 1 + static_cast<int>(random() % 20);
    double sum = 0;
    int differences = 0;
    for (Eigen::Index i = 0; i + 2 * m <= count; ++i, ++differences) {
      sum += std::pow(values.segment(i + m, m).mean() - values.segment(i, m).mean(), 2);
    }
    EXPECT_NEAR(overlapping_allan_deviation(values, m), std::sqrt(sum / differences / 2), 1e-10);
  }
}

TEST(AllanDeviation, OfALineIsItsSlope) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(100, 5, 5 + 99 * 0.25);
  for (const int m : {1, 3, 20}) EXPECT_NEAR(overlapping_allan_deviation(line, m), 0.25 * m / std::sqrt(2), 1e-11);
}

TEST(AllanCurve, OfOneStretchIsTheDeviationInOctaves) {
  const RateStretches rates{.interval_s = 2, .values = {nist_values()}};
  const AllanCurve curve = allan_curve(rates);
  ASSERT_EQ(curve.size(), 9U) << "m = 256 leaves three means, 512 one";
  for (const AllanPoint& point : curve) {
    EXPECT_EQ(point.tau_s, 2.0 * point.m);
    EXPECT_EQ(point.differences, 1001 - 2 * point.m);
    EXPECT_NEAR(point.deviation_deg_per_h, overlapping_allan_deviation(nist_values(), point.m), 1e-14);
    const int clusters = 1000 / point.m;
    EXPECT_NEAR(point.error_deg_per_h / point.deviation_deg_per_h, 1 / std::sqrt(2.0 * (clusters - 1)), 1e-14);
  }
}

TEST(AllanCurve, AveragesTheSquaresOfAllStretches) {
  std::mt19937_64 random(3);
  const Eigen::VectorXd a = simulate({.N = 1}, 64, 1, random), b = simulate({.N = 5}, 40, 1, random);
  const AllanCurve curve = allan_curve({.interval_s = 1, .values = {a, b}});
  const double square_a = std::pow(overlapping_allan_deviation(a, 4), 2);
  const double square_b = std::pow(overlapping_allan_deviation(b, 4), 2);
  EXPECT_EQ(curve[2].differences, 57 + 33);
  EXPECT_NEAR(curve[2].deviation_deg_per_h, std::sqrt((57 * square_a + 33 * square_b) / 90), 1e-9);
}

TEST(AllanCurve, NeverBridgesAGap) {
  std::mt19937_64 random(4);
  Eigen::VectorXd values = simulate({.N = 0.001}, 300, 1, random);
  values.tail(200).array() += 1000;  // a step, hidden in the gaps
  Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(300, 0, 299);
  time_s.tail(200).array() += 17;
  const RateStretches by_time = cut_at_gaps(time_s, values, 1);
  ASSERT_EQ(by_time.values.size(), 2U);
  EXPECT_LT(allan_curve(by_time).front().deviation_deg_per_h, 1);

  values(100) = std::numeric_limits<double>::quiet_NaN();
  const RateStretches by_nan = cut_at_gaps(Eigen::VectorXd::LinSpaced(300, 0, 299), values, 1);
  ASSERT_EQ(by_nan.values.size(), 2U);
  EXPECT_EQ(by_nan.values[0].size(), 100);
  EXPECT_EQ(by_nan.values[1].size(), 199);
  EXPECT_LT(allan_curve(by_nan).front().deviation_deg_per_h, 1);
}

TEST(AllanCurve, OfTooLittleIsEmpty) {
  EXPECT_TRUE(allan_curve({.interval_s = 1, .values = {}}).empty());
  EXPECT_TRUE(allan_curve({.interval_s = 1, .values = {Eigen::Vector2d{1, 2}}}).empty());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d nothing{kNone, kNone, kNone};
  EXPECT_TRUE(cut_at_gaps(Eigen::Vector3d{0, 1, 2}, nothing, 1).values.empty());
}

/// Rates about x, y and z of the recording of a real laser gyro unit: counts of 0.1 arcsec in 10 ms after fourteen
/// lines of text.
Eigen::MatrixXd laser_gyro_rates(const std::string& file) {
  std::ifstream stream(file);
  std::string line;
  constexpr int kHead = 14;
  for (int k = 0; k < kHead; ++k) std::getline(stream, line);
  std::vector<double> counts;
  for (double number{}; stream >> number;) counts.push_back(number);
  const auto rows = static_cast<Eigen::Index>(counts.size()) / 6;
  return 10 * Eigen::Map<Eigen::MatrixXd>(counts.data(), 6, rows).topRows(3).transpose();
}

TEST(AllanDeviation, OfARealLaserGyroIsTheReference) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
  const Eigen::MatrixXd rates = laser_gyro_rates(std::string(shared) + "/data/lasergyro.imu");
  ASSERT_EQ(rates.rows(), 184718);
  const double at_1_10_100_s[3][3] = {{17.3530, 8.4203, 2.0748}, {60.6565, 14.6920, 2.6611}, {8.7062, 1.4945, 0.25052}};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    int m = 100;
    for (const double expected : at_1_10_100_s[axis]) {
      EXPECT_NEAR(overlapping_allan_deviation(rates.col(axis), m), expected, 6e-5) << axis << ", " << m;
      m *= 10;
    }
  }
}

}  // namespace
}  // namespace gyrotherm
