// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/warm_start.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/svm/kernel.hpp"
#include "analysis/svm/tuning.hpp"

namespace gyrotherm::svm {
namespace {

#ifdef GYROTHERM_NIGHTLY
constexpr std::uint64_t kWarmPositions = 10000;
#else
constexpr std::uint64_t kWarmPositions = 300;
#endif

double drawn_between(std::mt19937_64& generator, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}

// Returns a random position in the whole search box.
SvrParameters drawn_position(std::mt19937_64& generator) {
  return {.C = std::exp2(drawn_between(generator, -2, 12)),
          .sigma = std::exp2(drawn_between(generator, -2, 3.5)),
          .epsilon = std::exp2(drawn_between(generator, -8, -1))};
}

/// Rows of a smooth function of three inputs with noise. Each fold holds out a quarter of them.
struct WarmData {
  SampleMatrix x;
  Eigen::VectorXd y;

  WarmData(Eigen::Index rows, std::uint64_t seed) : x(rows, 3), y(rows) {
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal;
    for (Eigen::Index i = 0; i < rows; ++i) {
      for (Eigen::Index k = 0; k < 3; ++k) x(i, k) = normal(generator);
      y[i] = std::sin(x(i, 0)) + 0.3 * x(i, 1) * x(i, 2) + 0.05 * normal(generator);
    }
  }
  [[nodiscard]] TuningFold without_quarter(Eigen::Index quarter) const {
    TuningFold fold;
    for (Eigen::Index i = 0; i < y.size(); ++i)
      if (i % 4 != quarter) fold.train_rows.push_back(i);
    fold.train_x = x(fold.train_rows, Eigen::all);
    fold.train_y = y(fold.train_rows);
    return fold;
  }
};

// Computes D(β) by its definition.
double dual_objective(const TuningFold& fold, const SvrParameters& p, const Eigen::VectorXd& beta) {
  const Eigen::MatrixXd kernel = gaussian_kernel(fold.train_x, fold.train_x, p.sigma);
  return 0.5 * beta.dot(kernel * beta) - fold.train_y.dot(beta) + p.epsilon * beta.lpNorm<1>();
}

/// Requires that two solutions agree. Both are optimal within the given gap, so their dual objectives D differ by at
/// most that gap.
void expect_agreement(const TuningFold& fold, const SvrParameters& p, const SvrSolution& warm, const SvrSolution& cold,
                      double relative_gap) {
  EXPECT_LE(warm.relative_gap, relative_gap);
  EXPECT_LE(warm.beta.lpNorm<Eigen::Infinity>(), p.C);
  EXPECT_NEAR(warm.beta.sum(), 0, 1e-12 * p.C * static_cast<double>(warm.beta.size()));
  const double warm_objective = dual_objective(fold, p, warm.beta), cold_objective = dual_objective(fold, p, cold.beta);
  const double scale = std::max(std::abs(warm_objective), std::abs(cold_objective));
  const double floor = 1e-9 * p.C * fold.train_y.cwiseAbs().sum();
  EXPECT_NEAR(warm_objective, cold_objective, relative_gap * scale + floor);
}

TEST(WarmStart, AgreesWithColdStartWithinCertifiedGap) {
  constexpr double kGap = 1e-3;
  KernelMemory memory;
  for (std::uint64_t seed = 1; seed <= kWarmPositions; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 generator(seed);
    const WarmData data(40 + static_cast<Eigen::Index>(generator() % 160), seed);
    const TuningFold first = data.without_quarter(0), second = data.without_quarter(1);
    const GaussianSamples first_samples(first.train_x), second_samples(second.train_x);
    const SvrParameters before = drawn_position(generator);
    const auto solved = solve_svr(first_samples, memory, first.train_y, before, {.relative_gap = kGap});
    ASSERT_TRUE(solved) << text(solved.error());
    const SvrStart end{solved->beta, before.C};

    // Starts another fold at the same position, and the same fold at another position (near or random).
    const SvrStart seeded = FoldSeed::between(first, second)->start(end);
    const auto warm = solve_svr(second_samples, memory, second.train_y, before, {.relative_gap = kGap}, &seeded);
    const auto cold = solve_svr(second_samples, memory, second.train_y, before, {.relative_gap = kGap});
    ASSERT_TRUE(warm && cold);
    expect_agreement(second, before, *warm, *cold, kGap);

    SvrParameters after = drawn_position(generator);
    if (seed % 2 == 0) after = {before.C * 1.3, before.sigma * 0.9, before.epsilon * 1.1};
    const auto moved = solve_svr(first_samples, memory, first.train_y, after, {.relative_gap = kGap}, &end);
    const auto cold_moved = solve_svr(first_samples, memory, first.train_y, after, {.relative_gap = kGap});
    ASSERT_TRUE(moved && cold_moved);
    expect_agreement(first, after, *moved, *cold_moved, kGap);
  }
}

TEST(WarmStart, AgreesWithColdStartForLargeTraining) {
  KernelMemory memory;
  const WarmData data(1100, 3);  // more than one working set
  const TuningFold first = data.without_quarter(0), second = data.without_quarter(1);
  const GaussianSamples first_samples(first.train_x), second_samples(second.train_x);
  for (const double C : {1.0, 60.0, 2000.0}) {
    SCOPED_TRACE(C);
    const SvrParameters at{.C = C, .sigma = 1.2, .epsilon = 0.03};
    const auto solved = solve_svr(first_samples, memory, first.train_y, at, {});
    ASSERT_TRUE(solved) << text(solved.error());
    const SvrStart seeded = FoldSeed::between(first, second)->start({solved->beta, C});
    const auto warm = solve_svr(second_samples, memory, second.train_y, at, {}, &seeded);
    const auto cold = solve_svr(second_samples, memory, second.train_y, at, {});
    ASSERT_TRUE(warm && cold);
    expect_agreement(second, at, *warm, *cold, SvrOptions{}.relative_gap);
  }
}

TEST(FoldSeed, KeepsSharedRowsAndMovesOthersToNeighbours) {
  const WarmData data(80, 5);
  const TuningFold first = data.without_quarter(0), second = data.without_quarter(1);
  SvrStart end{Eigen::VectorXd::Zero(first.train_y.size()), 2};
  for (Eigen::Index i = 0; i < end.beta.size(); ++i) end.beta[i] = i % 3 == 0 ? 0.2 : i % 3 == 1 ? -0.15 : -0.05;
  const auto seed = FoldSeed::between(first, second);
  ASSERT_TRUE(seed);
  const SvrStart start = seed->start(end);
  ASSERT_EQ(start.beta.size(), second.train_y.size());
  EXPECT_LE(start.beta.lpNorm<Eigen::Infinity>(), 2);
  EXPECT_NEAR(start.beta.sum(), end.beta.sum(), 1e-12);
  for (std::size_t i = 0; i < second.train_rows.size(); ++i) {
    const auto same = std::ranges::find(first.train_rows, second.train_rows[i]);
    if (same == first.train_rows.end()) continue;
    EXPECT_EQ(start.beta[static_cast<Eigen::Index>(i)], end.beta[same - first.train_rows.begin()]);
  }
  // Scales β so that the bounds limit the start.
  end.beta *= 10;
  EXPECT_LE(seed->start(end).beta.lpNorm<Eigen::Infinity>(), 2);
}

TEST(FoldSeed, IsMissingWhenRowsOrInputsDiffer) {
  const WarmData data(40, 6);
  const TuningFold known = data.without_quarter(0);
  TuningFold unknown = data.without_quarter(1);
  unknown.train_rows.clear();
  EXPECT_FALSE(FoldSeed::between(known, unknown));
  EXPECT_FALSE(FoldSeed::between(unknown, known));
  TuningFold other_inputs = data.without_quarter(1);
  other_inputs.train_x = other_inputs.train_x.leftCols(2).eval();
  EXPECT_FALSE(FoldSeed::between(known, other_inputs));
}

TEST(FeasibleStart, IsFeasibleOrMissing) {
  const WarmData data(60, 7);
  const TuningFold fold = data.without_quarter(0);
  const GaussianSamples samples(fold.train_x);
  const Eigen::Ref<const Eigen::VectorXd> y(fold.train_y);
  KernelMemory memory;
  Kernel kernel(samples, 1.0, memory, 0);
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 generator(seed);
    const SvrProblem problem{kernel, y, std::exp2(drawn_between(generator, -2, 12)), 0.1};
    SvrStart start{Eigen::VectorXd(y.size()), std::exp2(drawn_between(generator, -2, 12))};
    for (double& beta : start.beta) beta = std::clamp(drawn_between(generator, -1.5, 1.5), -1.0, 1.0) * start.bound;
    const auto feasible = feasible_start(problem, start);
    if (!feasible) continue;
    EXPECT_LE(feasible->lpNorm<Eigen::Infinity>(), problem.C);
    EXPECT_NEAR(feasible->sum(), 0, 1e-12 * problem.C * static_cast<double>(problem.size()));
  }
  const SvrProblem problem{kernel, y, 3, 0.1};
  EXPECT_FALSE(feasible_start(problem, {Eigen::VectorXd::Constant(y.size(), 1), 1}))
      << "all coefficients are at the same bound";
}

}  // namespace
}  // namespace gyrotherm::svm
