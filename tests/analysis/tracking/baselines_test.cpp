// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/baselines.hpp"

#include <gtest/gtest.h>

#include <set>

#include "analysis/tracking/bias_tracker.hpp"
#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

TEST(TrailingMeans, AverageAvailableRates) {
  const Eigen::VectorXd rates = (Eigen::VectorXd(6) << kMissing, 1, 2, kMissing, 6, 4).finished();
  const Eigen::VectorXd expected = (Eigen::VectorXd(6) << 0, 1, 1.5, 1.5, 4, 5).finished();
  EXPECT_EQ(trailing_means(rates, 3), expected);
  const Eigen::VectorXd filled = (Eigen::VectorXd(6) << 0, 1, 2, 2, 6, 4).finished();
  EXPECT_EQ(fill_gaps(rates), filled);
}

TEST(RecursivePrediction, MatchesWeightedLeastSquares) {
  const Eigen::VectorXd values = white_noise(60, 1);
  const RecursivePrediction options{.order = 3, .forgetting = 0.95};
  const Eigen::VectorXd next = predict_next(values, options);
  Eigen::MatrixXd normal = values.head(3).squaredNorm() * Eigen::MatrixXd::Identity(3, 3);
  Eigen::VectorXd right = normal * Eigen::VectorXd::Constant(3, 1.0 / 3);
  for (Eigen::Index k = 3; k < 60; ++k) {
    const Eigen::VectorXd before = values.segment(k - 3, 3).reverse();
    normal = (0.95 * normal + before * before.transpose()).eval();
    right = (0.95 * right + values(k) * before).eval();
    const Eigen::VectorXd weights = normal.ldlt().solve(right);
    EXPECT_NEAR(next(k), weights.dot(values.segment(k - 2, 3).reverse()), 1e-11) << k;
  }
}

TEST(RecursivePrediction, PredictsSineAfterAdaptation) {
  const Eigen::VectorXd sine =
      Eigen::VectorXd::NullaryExpr(400, [](Eigen::Index k) { return std::sin(0.3 * static_cast<double>(k)); });
  const Eigen::VectorXd next = predict_next(sine, {.order = 2, .forgetting = 0.9});
  for (Eigen::Index k = 300; k + 1 < 400; ++k) EXPECT_NEAR(next(k), sine(k + 1), 1e-9);
}

TEST(Denoisers, AreCausal) {
  const StateSpace space = virtual_space();
  Eigen::VectorXd rates = known_bias(400, 1).measured_deg_per_h;
  rates(120) = kMissing;
  Eigen::VectorXd other = rates;
  other.tail(100).array() += 1;
  std::set<std::string> names;
  for (const Denoiser& denoiser : denoisers(space)) {
    names.insert(denoiser.name);
    const DenoiserOutput one = denoiser.denoise(rates), two = denoiser.denoise(other);
    ASSERT_EQ(one.bias.size(), 400);
    ASSERT_EQ(one.next_hour.size(), 400);
    const Eigen::Index known = 300 - denoiser.latency;
    EXPECT_EQ(one.bias.segment(denoiser.latency, known), two.bias.segment(denoiser.latency, known)) << denoiser.name;
    EXPECT_EQ(one.next_hour.array().isNaN().all(), denoiser.latency > 0) << denoiser.name;
    if (denoiser.latency == 0) {
      EXPECT_EQ(one.next_hour.head(known), two.next_hour.head(known)) << denoiser.name;
    }
    EXPECT_TRUE(one.bias.tail(400 - denoiser.latency).allFinite()) << denoiser.name << " has a gap";
  }
  EXPECT_EQ(names.size(), 9u);
}

TEST(Denoisers, ReturnConstantForConstantRate) {
  const StateSpace space = virtual_space();
  int denoised_constants = 0;
  for (const Denoiser& denoiser : denoisers(space)) {
    if (denoiser.name == "thermal model alone") continue;
    ++denoised_constants;
    const DenoiserOutput denoised = denoiser.denoise(Eigen::VectorXd::Constant(3000, 0.01));
    EXPECT_NEAR(denoised.bias(2999), 0.01, 2e-4) << denoiser.name;
  }
  EXPECT_EQ(denoised_constants, 8);
}

TEST(Denoisers, MatchTrackerForKalmanFilter) {
  const StateSpace space = virtual_space();
  const Eigen::VectorXd rates = known_bias(200, 2).measured_deg_per_h;
  const auto all = denoisers(space);
  const auto kalman = std::ranges::find(all, "Kalman", &Denoiser::name);
  ASSERT_NE(kalman, all.end());
  BiasTracker tracker(space);
  for (const double rate : rates) tracker.push(rate);
  EXPECT_EQ(kalman->denoise(rates).bias(199), tracker.estimate().deg_per_h);
  EXPECT_EQ(kalman->denoise(rates).next_hour(199), tracker.forecast(36).deg_per_h);
}

TEST(Wavelet, IsOrthogonalAndInvertible) {
  for (const Eigen::Index count : {4, 6, 64, 1000}) {
    const Eigen::VectorXd values = white_noise(count, 1), coefficients = wavelet_step(values);
    EXPECT_NEAR(coefficients.norm(), values.norm(), 1e-12 * values.norm());
    EXPECT_LT((wavelet_step_back(coefficients) - values).cwiseAbs().maxCoeff(), 1e-13);
  }
}

TEST(Wavelet, HasTwoVanishingMoments) {
  const Eigen::VectorXd coefficients = wavelet_step(Eigen::VectorXd::LinSpaced(64, -3, 5));
  EXPECT_LT(coefficients.segment(32, 31).cwiseAbs().maxCoeff(), 1e-13) << "except at the joined ends of the line";
}

TEST(WaveletDenoising, KeepsConstant) {
  for (const Eigen::Index count : {1, 2, 5, 8, 100, 256, 300}) {
    const Eigen::VectorXd denoised = wavelet_denoised(Eigen::VectorXd::Constant(count, 0.7));
    EXPECT_LT((denoised.array() - 0.7).abs().maxCoeff(), 1e-13) << count;
  }
}

TEST(WaveletDenoising, RemovesMostOfWhiteNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Eigen::VectorXd values = white_noise(1024, seed);
    EXPECT_LT(wavelet_denoised(values).norm(), 0.15 * values.norm())
        << "at the coarsest level each value is a mean of 256";
  }
}

TEST(WaveletDenoising, KeepsLargeStep) {
  Eigen::VectorXd values = 0.01 * white_noise(512, 3);
  values.tail(200).array() += 1;
  const Eigen::VectorXd denoised = wavelet_denoised(values);
  EXPECT_LT(denoised(311), 0.1);
  EXPECT_GT(denoised(312), 0.9);
}

TEST(WaveletDenoising, DoesNotCoupleEnds) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(256, 0, 1);
  const Eigen::VectorXd denoised = wavelet_denoised(line + 1e-6 * white_noise(256, 4));
  EXPECT_LT((denoised - line).cwiseAbs().maxCoeff(), 0.02);
}

TEST(WaveletDenoising, IsCausalInWindows) {
  const Eigen::VectorXd values = white_noise(400, 5);
  for (const Eigen::Index delay : {0, 36}) {
    const Eigen::VectorXd denoised = wavelet_denoised_in_windows(values, 128, delay);
    Eigen::VectorXd other = values;
    other.tail(100).array() += 5;
    EXPECT_EQ(wavelet_denoised_in_windows(other, 128, delay).segment(delay, 300 - delay),
              denoised.segment(delay, 300 - delay));
    EXPECT_EQ(denoised(399), wavelet_denoised(values.tail(128))(127 - delay));
    EXPECT_TRUE(denoised.head(delay).array().isNaN().all());
  }
}

}  // namespace
}  // namespace gyrotherm::tracking
