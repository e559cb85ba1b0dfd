// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/smo.hpp"

namespace gyrotherm::svm {
namespace {

using Inputs = SampleMatrix;

Inputs random_samples(Eigen::Index n, Eigen::Index inputs, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  return Inputs::NullaryExpr(n, inputs, [&] { return normal(generator); });
}

double by_definition(const Inputs& x, Eigen::Index i, Eigen::Index j, double sigma) {
  return std::exp(-(x.row(i) - x.row(j)).squaredNorm() / (2 * sigma * sigma));
}

TEST(GaussianSamples, ComputeKernelInBothPrecisions) {
  for (const Eigen::Index n : {1, 15, 33, 70}) {
    const Inputs x = random_samples(n, 5, n);
    const GaussianSamples samples(x);
    std::vector<float> row(padded_row(n));
    std::vector<double> column(padded_column(n));
    for (const double sigma : {0.05, 0.7, 12.0}) {
      samples.compute_float_row(n / 2, sigma, row.data());
      samples.compute_double_column(n / 2, sigma, column.data());
      for (Eigen::Index j = 0; j < n; ++j) {
        const double expected = by_definition(x, n / 2, j, sigma);
        EXPECT_NEAR(column[j], expected, 1e-15 + 3e-13 * expected) << "n " << n << " sigma " << sigma;
        EXPECT_NEAR(row[j], expected, 3e-5 * expected + 1e-30) << "n " << n << " sigma " << sigma;
      }
      EXPECT_EQ(column[n / 2], 1);
      EXPECT_EQ(row[n / 2], 1.0F);
    }
  }
}

TEST(GaussianSamples, GiveOneForEqualSamples) {
  Inputs x = random_samples(20, 13, 3);
  x.row(7) = x.row(11);
  const GaussianSamples samples(x);
  std::vector<float> row(padded_row(20));
  std::vector<double> column(padded_column(20));
  samples.compute_float_row(7, 0.01, row.data());
  samples.compute_double_column(7, 0.01, column.data());
  EXPECT_EQ(row[11], 1.0F);
  EXPECT_EQ(column[11], 1);
}

TEST(Kernel, ReturnsSameColumnsWithAndWithoutCache) {
  const Inputs x = random_samples(50, 3, 4);
  const GaussianSamples samples(x);
  KernelMemory much_memory, little_memory;
  Kernel much(samples, 0.8, much_memory, std::size_t{1} << 20);
  Kernel little(samples, 0.8, little_memory, 0);
  for (int round = 0; round < 2; ++round) {
    for (Eigen::Index i = 0; i < 50; ++i) {
      const double *kept = much.column(i), *recomputed = little.column(i);
      for (Eigen::Index j = 0; j < 50; ++j) ASSERT_EQ(kept[j], recomputed[j]) << i << ", " << j;
    }
  }
}

TEST(Kernel, ReusesMemoryForAnotherSize) {
  KernelMemory memory;
  for (const Eigen::Index n : {30, 80, 10}) {
    const Inputs x = random_samples(n, 2, n);
    const GaussianSamples samples(x);
    Kernel kernel(samples, 1.5, memory, std::size_t{1} << 20);
    for (Eigen::Index i = 0; i < n; ++i) {
      EXPECT_NEAR(kernel.column(i)[n - 1], by_definition(x, i, n - 1, 1.5), 1e-14);
      EXPECT_NEAR(kernel.row(i)[n - 1], by_definition(x, i, n - 1, 1.5), 1e-5);
    }
  }
}

/// The optimum of two points is known; their kernel value is kBetween.
TEST(Smo, MovesPairToOptimum) {
  constexpr float kBetween = 0.25F;
  const std::vector<float> first = {1, kBetween}, second = {kBetween, 1};
  SmoState state(10, 0.125);
  state.resize(2);
  std::vector<float> rows[2] = {first, second};
  for (auto& row : rows) row.resize(state.stride());
  state.set_point(0, 0, 1);
  state.set_point(1, 0, -1);
  const SmoRun run = state.run([&](int i) { return rows[i].data(); }, 1e-6, 0, 100);
  EXPECT_LE(run.violation, 1e-6);
  EXPECT_NEAR(state.beta(0), (1 - 0.125) / (1 - kBetween), 1e-6);
  EXPECT_EQ(state.beta(0), -state.beta(1));
}

TEST(Smo, KeepsBoundsBalanceAndErrors) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const int n = 24 + static_cast<int>(seed);
    const Inputs x = random_samples(n, 3, seed);
    const Eigen::VectorXd y = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
    const double C = std::exp2(static_cast<double>(seed % 10) - 2), epsilon = 0.02;
    const GaussianSamples samples(x);
    SmoState state(C, epsilon);
    state.resize(n);
    std::vector<std::vector<float>> rows(n, std::vector<float>(state.stride()));
    for (int i = 0; i < n; ++i) {
      samples.compute_float_row(i, 1.5, rows[i].data());
      state.set_point(i, 0, static_cast<float>(y[i]));
    }
    const SmoRun run = state.run([&](int i) { return rows[i].data(); }, 1e-3, 0, 200 * n);
    EXPECT_LE(run.violation, 1e-3);
    const Eigen::Map<const Eigen::VectorXd> beta(state.beta().data(), n);
    EXPECT_LE(beta.lpNorm<Eigen::Infinity>(), C);
    EXPECT_NEAR(beta.sum(), 0, 1e-12 * C * n);
    for (int i = 0; i < n; ++i) {
      double error = y[i];
      for (int j = 0; j < n; ++j) error -= static_cast<double>(rows[i][j]) * beta[j];
      EXPECT_NEAR(state.error(i), error, 1e-5 * C);
    }
  }
}

TEST(Exponentiate, AgreesWithStandardLibrary) {
  constexpr int kCount = 100003;
  Eigen::VectorXd values(kCount);
  for (int i = 0; i < kCount; ++i) values[i] = 700.0 * i / kCount * std::pow(10.0, -(i % 4));
  Eigen::VectorXd exponentials(kCount);
  exponentiate(values.data(), kCount, -1, exponentials.data());
  for (int i = 0; i < kCount; ++i) ASSERT_NEAR(exponentials[i] / std::exp(-values[i]), 1, 4e-16) << values[i];
}

TEST(Exponentiate, IsExactAtZeroAndUnderflowsToZero) {
  Eigen::VectorXd values(3);
  values << 0.0, 709.0, 1e300;
  exponentiate(values.data(), values.size(), -1, values.data());
  EXPECT_EQ(values[0], 1);
  EXPECT_EQ(values[1], 0);
  EXPECT_EQ(values[2], 0);
}

}  // namespace
}  // namespace gyrotherm::svm
