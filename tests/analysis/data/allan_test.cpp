// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/allan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/analysis/synthetic_run.hpp"

namespace gyrotherm::data {
namespace {

/// Returns the 1000 points of NIST SP 1065, section 12.4.
Eigen::VectorXd nist_values() {
  Eigen::VectorXd values(1000);
  std::int64_t n = 1234567890;
  for (double& value : values) {
    value = static_cast<double>(n) / 2147483647.0;
    n = 16807 * n % 2147483647;
  }
  return values;
}

/// Computes the overlapping Allan deviation of evenly spaced values for the averaging factor m.
double deviation_at(const Eigen::VectorXd& values, int m) {
  return allan_point({.interval_s = 1, .values = {values}}, m).deviation_deg_per_h;
}

TEST(AllanDeviation, MatchesNistReference) {
  const Eigen::VectorXd values = nist_values();
  EXPECT_NEAR(values(0), 0.5748904732, 5e-11);
  EXPECT_NEAR(values(999), 0.7264947764, 5e-11);
  EXPECT_NEAR(values.mean(), 0.4897745, 5e-8);
  EXPECT_NEAR(deviation_at(values, 1), 2.922319e-01, 5e-8);
  EXPECT_NEAR(deviation_at(values, 10), 9.159953e-02, 5e-9);
  EXPECT_NEAR(deviation_at(values, 100), 3.241343e-02, 5e-9);
}

TEST(AllanDeviation, EqualsRootMeanSquareDifferenceOfNeighbouringMeans) {
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
    EXPECT_NEAR(deviation_at(values, m), std::sqrt(sum / differences / 2), 1e-10);
  }
}

TEST(AllanDeviation, IsProportionalToSlopeOfLine) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(100, 5, 5 + 99 * 0.25);
  for (const int m : {1, 3, 20}) EXPECT_NEAR(deviation_at(line, m), 0.25 * m / std::sqrt(2), 1e-11);
}

TEST(AllanCurve, ComputesDeviationInOctavesForOneStretch) {
  const RateStretches rates{.interval_s = 2, .values = {nist_values()}};
  const AllanCurve curve = allan_curve(rates);
  ASSERT_EQ(curve.size(), 9U) << "there are three means at m = 256, and one at m = 512";
  for (const AllanPoint& point : curve) {
    EXPECT_EQ(point.tau_s, 2.0 * point.m);
    EXPECT_EQ(point.differences, 1001 - 2 * point.m);
    EXPECT_NEAR(point.deviation_deg_per_h, deviation_at(nist_values(), point.m), 1e-14);
    const int clusters = 1000 / point.m;
    EXPECT_NEAR(point.error_deg_per_h / point.deviation_deg_per_h, 1 / std::sqrt(2.0 * (clusters - 1)), 1e-14);
  }
}

TEST(AllanCurve, AveragesSquaresOfAllStretches) {
  std::mt19937_64 random(3);
  const Eigen::VectorXd a = simulate({.N = 1}, 64, 1, random), b = simulate({.N = 5}, 40, 1, random);
  const AllanCurve curve = allan_curve({.interval_s = 1, .values = {a, b}});
  const double square_a = std::pow(deviation_at(a, 4), 2);
  const double square_b = std::pow(deviation_at(b, 4), 2);
  EXPECT_EQ(curve[2].differences, 57 + 33);
  EXPECT_NEAR(curve[2].deviation_deg_per_h, std::sqrt((57 * square_a + 33 * square_b) / 90), 1e-9);
}

TEST(AllanCurve, DoesNotBridgeGaps) {
  std::mt19937_64 random(4);
  Eigen::VectorXd values = simulate({.N = 0.001}, 300, 1, random);
  // Adds a step at the gap.
  values.tail(200).array() += 1000;
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

TEST(AllanCurve, IsEmptyForTooFewSamples) {
  EXPECT_TRUE(allan_curve({.interval_s = 1, .values = {}}).empty());
  EXPECT_TRUE(allan_curve({.interval_s = 1, .values = {Eigen::Vector2d{1, 2}}}).empty());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d nothing{kNone, kNone, kNone};
  EXPECT_TRUE(cut_at_gaps(Eigen::Vector3d{0, 1, 2}, nothing, 1).values.empty());
}

/// Reads the rates about x, y and z from the recording of a real laser gyro unit. After fourteen header lines, the file
/// has counts of 0.1 arcsec per 10 ms.
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

TEST(AllanDeviation, MatchesReferenceForRealLaserGyro) {
  const char* shared = std::getenv("GYROTHERM_SHARED");
  if (shared == nullptr) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
  const Eigen::MatrixXd rates = laser_gyro_rates(std::string(shared) + "/data/lasergyro.imu");
  ASSERT_EQ(rates.rows(), 184718);
  const double at_1_10_100_s[3][3] = {{17.3530, 8.4203, 2.0748}, {60.6565, 14.6920, 2.6611}, {8.7062, 1.4945, 0.25052}};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    int m = 100;
    for (const double expected : at_1_10_100_s[axis]) {
      EXPECT_NEAR(deviation_at(rates.col(axis), m), expected, 6e-5) << axis << ", " << m;
      m *= 10;
    }
  }
}

RateStretches simulated(const SimulatedNoise& noise, int stretches, Eigen::Index samples, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  RateStretches rates{.interval_s = 1, .values = {}};
  for (int k = 0; k < stretches; ++k) rates.values.push_back(simulate(noise, samples, 1, random));
  return rates;
}

AllanFit fitted(const RateStretches& rates) { return fit_allan(allan_curve(rates), rates); }

/// Collects the errors of a coefficient over several seeds, in units of its standard error. Requires that each
/// coefficient is significant and within four standard errors of the true value. The destructor requires that the
/// spread over the seeds matches the standard errors.
class Pulls {
 public:
  Pulls(NoiseTerm term, double truth) : term_(term), truth_(truth) {}
  void add(const AllanFit& fit) {
    const NoiseCoefficient& found = find_coefficient(fit, term_);
    EXPECT_TRUE(found.seen) << info(term_).symbol;
    const double pull = (found.value - truth_) / found.error;
    EXPECT_LT(std::abs(pull), 4) << info(term_).symbol << ' ' << found.value << " ± " << found.error;
    squares_ += pull * pull;
    ++count_;
  }
  ~Pulls() {
    const double spread = std::sqrt(squares_ / count_);
    EXPECT_GT(spread, 0.6) << info(term_).symbol << ": the error bars are too wide";
    EXPECT_LT(spread, 1.5) << info(term_).symbol << ": the error bars are too narrow";
  }

 private:
  NoiseTerm term_;
  double truth_;
  double squares_ = 0;
  int count_ = 0;
};

TEST(AllanFit, RecoversAngleRandomWalkOfHolds) {
  Pulls n(NoiseTerm::angle_random_walk, 3e-4);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const AllanFit fit = fitted(simulated({.N = 3e-4}, 24, 3600, seed));
    n.add(fit);
    EXPECT_LT(find_coefficient(fit, NoiseTerm::angle_random_walk).error, 0.01 * 3e-4);
  }
}

TEST(AllanFit, FindsNoOtherTermInWhiteNoise) {
  int false_ones = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const AllanFit fit = fitted(simulated({.N = 3e-4}, 24, 3600, seed));
    for (const NoiseCoefficient& coefficient : fit.coefficients) {
      if (coefficient.term == NoiseTerm::angle_random_walk) continue;
      false_ones += coefficient.seen ? 1 : 0;
      EXPECT_GT(coefficient.at_most, 0) << seed << info(coefficient.term).symbol;
    }
  }
  EXPECT_LE(false_ones, 12) << "of 160 values, outside two standard errors";
}

TEST(AllanFit, RecoversRateRandomWalkWithAngleRandomWalk) {
  Pulls n(NoiseTerm::angle_random_walk, 3e-4), k(NoiseTerm::rate_random_walk, 8e-3);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const AllanFit fit = fitted(simulated({.N = 3e-4, .K = 8e-3}, 6, 14400, seed));
    n.add(fit);
    k.add(fit);
  }
}

TEST(AllanFit, RecoversBiasInstabilityWithAngleRandomWalk) {
  Pulls n(NoiseTerm::angle_random_walk, 3e-4), b(NoiseTerm::bias_instability, 3e-3);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const AllanFit fit = fitted(simulated({.N = 3e-4, .B = 3e-3}, 6, 4096, seed));
    n.add(fit);
    b.add(fit);
  }
}

TEST(AllanFit, RecoversQuantisationInArcseconds) {
  Pulls q(NoiseTerm::quantisation, 0.05), n(NoiseTerm::angle_random_walk, 3e-4);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const AllanFit fit = fitted(simulated({.Q = 0.05 / 3600, .N = 3e-4}, 10, 3600, seed));
    q.add(fit);
    n.add(fit);
  }
}

TEST(AllanFit, RecoversRateRamp) {
  Pulls n(NoiseTerm::angle_random_walk, 3e-4), r(NoiseTerm::rate_ramp, 6e-3);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const AllanFit fit = fitted(simulated({.N = 3e-4, .R = 6e-3}, 24, 3600, seed));
    n.add(fit);
    r.add(fit);
  }
}

/// The record has whole pulses of 0.1 arcsec at a steady rate. Rounding to pulses is not white noise, so the curve is
/// not a sum of the five terms.
TEST(AllanFit, RecoversAngleRandomWalkWhenPulsesBeatWithSampling) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    RateStretches rates{.interval_s = 1, .values = {}};
    for (int hold = 0; hold < 24; ++hold) {
      Eigen::VectorXd stretch = simulate({.N = 3e-4}, 3600, 1, random).array() + 10.636;
      double angle = 0, pulses = 0;
      for (double& rate : stretch) {
        angle += rate;
        const double before = std::exchange(pulses, std::floor(angle / 0.1));
        rate = 0.1 * (pulses - before);
      }
      rates.values.push_back(std::move(stretch));
    }
    const AllanFit fit = fitted(rates);
    EXPECT_GT(fit.misfit, 0);
    EXPECT_LT(fit.misfit, 0.2);
    const NoiseCoefficient& found = find_coefficient(fit, NoiseTerm::angle_random_walk);
    EXPECT_TRUE(found.seen);
    EXPECT_NEAR(found.value, 3e-4, 4 * found.error) << fit.misfit;
  }
}

TEST(AllanFit, BoundsInsignificantCoefficient) {
  int covered = 0;
  constexpr int kSeeds = 60;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const AllanFit fit = fitted(simulated({.N = 3e-4, .K = 5e-4}, 24, 3600, seed));
    const NoiseCoefficient& k = find_coefficient(fit, NoiseTerm::rate_random_walk);
    covered += k.at_most > 5e-4 ? 1 : 0;
  }
  EXPECT_GE(covered, 52) << "of 60 intervals at 95 %";
}

TEST(AllanFit, ScalesWithRate) {
  RateStretches rates = simulated({.N = 3e-4, .K = 8e-3}, 6, 14400, 7);
  const AllanFit small = fitted(rates);
  for (Eigen::VectorXd& stretch : rates.values) stretch *= 1e4;
  const AllanFit large = fitted(rates);
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    EXPECT_EQ(small.coefficients[k].seen, large.coefficients[k].seen);
    EXPECT_NEAR(large.coefficients[k].value, 1e4 * small.coefficients[k].value, 1e-6 * large.coefficients[k].value);
    EXPECT_NEAR(large.coefficients[k].at_most, 1e4 * small.coefficients[k].at_most,
                1e-5 * large.coefficients[k].at_most);
  }
}

TEST(AllanFit, ReadsEachTermAtItsAveragingTime) {
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    const auto term = static_cast<NoiseTerm>(k);
    const NoiseCoefficient coefficient{.term = term, .seen = true, .value = 3600, .error = 1, .at_most = 2};
    if (term == NoiseTerm::bias_instability) {
      EXPECT_NEAR(noise_deviation(coefficient, 100) / 3600, 0.66428, 5e-6);
      continue;
    }
    const double in_degrees = term == NoiseTerm::quantisation ? 1 : 3600;
    EXPECT_NEAR(noise_deviation(coefficient, info(term).read_off_s), in_degrees, 1e-9) << info(term).symbol;
  }
}

TEST(AllanFit, FitsOnlyChosenTerms) {
  const RateStretches rates = simulated({.Q = 1e-5, .N = 3e-4, .B = 1e-3}, 1, 20000, 11);
  const AllanCurve curve = allan_curve(rates);
  const AllanFit all = fit_allan(curve, rates);
  ASSERT_TRUE(find_coefficient(all, NoiseTerm::quantisation).seen);
  const AllanFit same = fit_allan(curve, rates,
                                  {NoiseTerm::rate_ramp, NoiseTerm::quantisation, NoiseTerm::angle_random_walk,
                                   NoiseTerm::bias_instability, NoiseTerm::rate_random_walk});
  const AllanFit two = fit_allan(curve, rates, {NoiseTerm::angle_random_walk, NoiseTerm::bias_instability});
  for (std::size_t k = 0; k < kNoiseTerms; ++k) EXPECT_EQ(same.coefficients[k].value, all.coefficients[k].value);
  EXPECT_FALSE(find_coefficient(two, NoiseTerm::quantisation).seen);
  EXPECT_GT(find_coefficient(two, NoiseTerm::angle_random_walk).value,
            find_coefficient(all, NoiseTerm::angle_random_walk).value)
      << "the fitted term includes the noise of the omitted ones";
}

TEST(AllanFit, FindsNoTermInConstantRate) {
  const RateStretches rates{.interval_s = 1, .values = {Eigen::VectorXd::Constant(200, 0.25)}};
  const AllanFit fit = fitted(rates);
  EXPECT_EQ(fit.coefficients.size(), 5u);
  for (const NoiseCoefficient& coefficient : fit.coefficients) EXPECT_FALSE(coefficient.seen);
}

TEST(AllanFit, FitsShortCurve) {
  for (Eigen::Index samples = 3; samples <= 40; ++samples) {
    std::mt19937_64 random(9);
    const RateStretches rates{.interval_s = 100, .values = {simulate({.N = 3e-4}, samples, 100, random)}};
    const AllanFit fit = fitted(rates);
    EXPECT_GE(find_coefficient(fit, NoiseTerm::angle_random_walk).value, 0) << samples;
  }
}

/// Simulates hourly means of a nearly continuous random walk, which has eight steps per hour.
Eigen::VectorXd hourly_means(const SimulatedNoise& noise, Eigen::Index hours, std::mt19937_64& random) {
  constexpr Eigen::Index kParts = 8;
  const Eigen::VectorXd parts = simulate(noise, kParts * hours, 3600.0 / kParts, random);
  return parts.reshaped(kParts, hours).colwise().mean().transpose();
}

/// Compares the computed covariances with the sample covariances of many simulated records.
TEST(AllanCovariance, MatchesSampleCovarianceOfManyRecords) {
  const std::vector<SimulatedNoise> noises = {{.N = 1}, {.Q = 1}, {.N = 0.2, .K = 1}, {.B = 1}, {.N = 1, .R = 4}};
  constexpr int kRecords = 3000;
  std::mt19937_64 random(11);
  for (const SimulatedNoise& noise : noises) {
    const NoiseSquares squares = NoiseSquares{noise.Q, noise.N, noise.B, noise.K, noise.R}.cwiseAbs2();
    RateStretches rates{.interval_s = 3600, .values = {}};
    Eigen::MatrixXd variances;
    for (int record = 0; record < kRecords; ++record) {
      rates.values = {hourly_means(noise, 40, random), hourly_means(noise, 24, random)};
      const AllanCurve curve = allan_curve(rates);
      variances.conservativeResize(static_cast<Eigen::Index>(curve.size()), kRecords);
      for (std::size_t k = 0; k < curve.size(); ++k) {
        variances(static_cast<Eigen::Index>(k), record) = std::pow(curve[k].deviation_deg_per_h, 2);
      }
    }
    const Eigen::MatrixXd computed = allan_covariance(allan_curve(rates), rates, squares);
    const Eigen::MatrixXd centred = variances.colwise() - variances.rowwise().mean();
    const Eigen::MatrixXd counted = centred * centred.transpose() / (kRecords - 1);
    const Eigen::VectorXd std = counted.diagonal().cwiseSqrt();
    for (Eigen::Index i = 0; i < counted.rows(); ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) {
        EXPECT_NEAR(computed(i, j) / (std(i) * std(j)), counted(i, j) / (std(i) * std(j)), 0.15)
            << "Q " << noise.Q << " N " << noise.N << " B " << noise.B << " K " << noise.K << ", m = 2^" << i << ", 2^"
            << j;
      }
    }
  }
}

}  // namespace

}  // namespace gyrotherm::data
