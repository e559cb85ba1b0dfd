// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/wavelet.hpp"

#include <gtest/gtest.h>

#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

TEST(Wavelet, IsOrthogonalAndGoesBack) {
  for (const Eigen::Index count : {4, 6, 64, 1000}) {
    const Eigen::VectorXd values = white_noise(count, 1), coefficients = wavelet_step(values);
    EXPECT_NEAR(coefficients.norm(), values.norm(), 1e-12 * values.norm());
    EXPECT_LT((wavelet_step_back(coefficients) - values).cwiseAbs().maxCoeff(), 1e-13);
  }
}

TEST(Wavelet, HasTwoVanishingMoments) {
  const Eigen::VectorXd coefficients = wavelet_step(Eigen::VectorXd::LinSpaced(64, -3, 5));
  EXPECT_LT(coefficients.segment(32, 31).cwiseAbs().maxCoeff(), 1e-13) << "but where the line's ends meet";
}

TEST(WaveletDenoising, LeavesAConstantAsItIs) {
  for (const Eigen::Index count : {1, 2, 5, 8, 100, 256, 300}) {
    const Eigen::VectorXd denoised = wavelet_denoised(Eigen::VectorXd::Constant(count, 0.7));
    EXPECT_LT((denoised.array() - 0.7).abs().maxCoeff(), 1e-13) << count;
  }
}

TEST(WaveletDenoising, TakesMostOfWhiteNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Eigen::VectorXd values = white_noise(1024, seed);
    EXPECT_LT(wavelet_denoised(values).norm(), 0.15 * values.norm()) << "a quarter is a mean of 256";
  }
}

TEST(WaveletDenoising, KeepsALargeStepWhereItIs) {
  Eigen::VectorXd values = 0.01 * white_noise(512, 3);
  values.tail(200).array() += 1;
  const Eigen::VectorXd denoised = wavelet_denoised(values);
  EXPECT_LT(denoised(311), 0.1);
  EXPECT_GT(denoised(312), 0.9);
}

TEST(WaveletDenoising, DoesNotCoupleTheEnds) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(256, 0, 1);
  const Eigen::VectorXd denoised = wavelet_denoised(line + 1e-6 * white_noise(256, 4));
  EXPECT_LT((denoised - line).cwiseAbs().maxCoeff(), 0.02);
}

TEST(WaveletDenoising, InWindowsSeesNothingThatIsToCome) {
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
