// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/wavelet.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrotherm::tracking {
namespace {

constexpr Eigen::Index kTaps = 4;

/// (1 + √3, 3 + √3, 3 − √3, 1 − √3)/(4√2).
constexpr std::array<double, kTaps> kLow = {0.48296291314453414, 0.83651630373780790, 0.22414386804201339,
                                            -0.12940952255126037};
constexpr std::array<double, kTaps> kHigh = {kLow[3], -kLow[2], kLow[1], -kLow[0]};

/// The place of `i` in `count` values that are continued by their mirror image again and again.
Eigen::Index mirrored(Eigen::Index i, Eigen::Index count) {
  const Eigen::Index there = i % (2 * count);
  return there < count ? there : 2 * count - 1 - there;
}

double median_magnitude(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Eigen::VectorXd magnitudes = values.cwiseAbs();
  auto* middle = magnitudes.data() + magnitudes.size() / 2;
  std::nth_element(magnitudes.data(), middle, magnitudes.data() + magnitudes.size());
  return *middle;
}

/// The power of two that holds so many values, at least 8.
Eigen::Index power_of_two(Eigen::Index count) {
  Eigen::Index power = 8;
  while (power < count) power *= 2;
  return power;
}

}  // namespace

Eigen::VectorXd wavelet_step(const Eigen::Ref<const Eigen::VectorXd>& values) {
  const Eigen::Index half = values.size() / 2;
  assert(values.size() == 2 * half && values.size() >= kTaps);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(values.size());
  for (Eigen::Index i = 0; i < half; ++i) {
    for (Eigen::Index tap = 0; tap < kTaps; ++tap) {
      const double value = values((2 * i + tap) % values.size());
      coefficients(i) += kLow[static_cast<std::size_t>(tap)] * value;
      coefficients(half + i) += kHigh[static_cast<std::size_t>(tap)] * value;
    }
  }
  return coefficients;
}

Eigen::VectorXd wavelet_step_back(const Eigen::Ref<const Eigen::VectorXd>& coefficients) {
  const Eigen::Index half = coefficients.size() / 2;
  assert(coefficients.size() == 2 * half && coefficients.size() >= kTaps);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(coefficients.size());
  for (Eigen::Index i = 0; i < half; ++i) {
    for (Eigen::Index tap = 0; tap < kTaps; ++tap) {
      values((2 * i + tap) % values.size()) += kLow[static_cast<std::size_t>(tap)] * coefficients(i) +
                                               kHigh[static_cast<std::size_t>(tap)] * coefficients(half + i);
    }
  }
  return values;
}

Eigen::VectorXd wavelet_denoised(const Eigen::Ref<const Eigen::VectorXd>& values) {
  constexpr double kMedianOfNormal = 0.6745;
  constexpr Eigen::Index kKept = 8;  // approximations of the doubled sequence
  const Eigen::Index count = values.size(), held = power_of_two(count);
  assert(count >= 1 && values.allFinite());
  Eigen::VectorXd all(2 * held);
  for (Eigen::Index i = 0; i < all.size(); ++i) all(i) = values(mirrored(mirrored(i, held), count));
  double threshold = 0;
  for (Eigen::Index length = all.size(); length > kKept; length /= 2) {
    all.head(length) = wavelet_step(all.head(length));
    auto details = all.segment(length / 2, length / 2);
    if (length == all.size()) {
      threshold = median_magnitude(details) / kMedianOfNormal * std::sqrt(2 * std::log(static_cast<double>(count)));
    }
    details = details.array().sign() * (details.array().abs() - threshold).max(0.0);
  }
  for (Eigen::Index length = 2 * kKept; length <= all.size(); length *= 2) {
    all.head(length) = wavelet_step_back(all.head(length));
  }
  return all.head(count);
}

Eigen::VectorXd wavelet_denoised_in_windows(const Eigen::Ref<const Eigen::VectorXd>& values, Eigen::Index window,
                                            Eigen::Index delay) {
  assert(0 <= delay && delay < window);
  Eigen::VectorXd denoised = Eigen::VectorXd::Constant(values.size(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = delay; k < values.size(); ++k) {
    const Eigen::Index length = std::min(window, k + 1);
    denoised(k) = wavelet_denoised(values.segment(k + 1 - length, length))(length - 1 - delay);
  }
  return denoised;
}

}  // namespace gyrotherm::tracking
