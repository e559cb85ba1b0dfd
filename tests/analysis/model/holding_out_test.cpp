/// Why users are not offered random folds: the figures of docs/evaluation.md that rest on a real record.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "analysis/data/folds.hpp"
#include "analysis/model/splits.hpp"
#include "tests/analysis/tofupilot.hpp"

namespace gyrotherm {
namespace {

FoldPlan at_random(Eigen::Index rows, int folds, std::uint64_t seed) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(rows));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::shuffle(order, std::mt19937_64(seed));
  FoldPlan plan{.folds = std::vector<FoldRows>(static_cast<std::size_t>(folds)), .statement = "random"};
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t f = 0; f < plan.folds.size(); ++f) {
      (i % plan.folds.size() == f ? plan.folds[f].held_out : plan.folds[f].training).push_back(order[i]);
    }
  }
  for (FoldRows& fold : plan.folds) {
    std::ranges::sort(fold.held_out);
    std::ranges::sort(fold.training);
  }
  return plan;
}

/// RMSE in °/s of the reference's SVR: C = 30, γ = 0.3, ε = 0.02.
double held_out_rmse(const Clusters& clusters, const FoldPlan& plan) {
  const Method& svr = **find_method("svr");
  const InputPlan inputs{.fixed = {temperature_term("T"), temperature_term("dT")}, .candidates = {}, .rule = {}};
  const EstimatorOptions estimator{svr, {{"C", 30}, {"sigma", std::sqrt(1 / (2 * 0.3))}, {"epsilon", 0.02}}, {}};
  const auto splits = split_at_folds({clusters, plan}, inputs, svr, {});
  const auto residual = leave_out_residual(*splits, clusters.start_s.size(), estimator, {});
  return std::sqrt(residual->squaredNorm() / static_cast<double>(residual->size())) / 3600;
}

FoldPlan six_blocks(const Clusters& clusters, std::optional<double> guard_minutes) {
  return *plan_folds({clusters}, {.kind = FoldKind::blocks, .blocks = 6, .guard_minutes = guard_minutes});
}

TEST(HoldingOut, ClustersAtRandomFlattersARealGyro) {
  const double at_random_reference[] = {0.0758, 0.0145, 0.0261}, blocks_reference[] = {0.2368, 0.1078, 0.1207};
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    const auto clusters = load_tofupilot(axis);
    if (!clusters) GTEST_SKIP() << "GYROTHERM_SHARED is not set";
    const double blocks = held_out_rmse(*clusters, six_blocks(*clusters, 0));
    const double guarded = held_out_rmse(*clusters, six_blocks(*clusters, std::nullopt));
    std::vector<double> random;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      random.push_back(held_out_rmse(*clusters, at_random(clusters->start_s.size(), 10, seed)));
      EXPECT_NEAR(random.back(), at_random_reference[axis], 0.1 * at_random_reference[axis]) << "seed " << seed;
      EXPECT_GT(blocks, 3 * random.back()) << "seed " << seed;
    }
    std::ranges::sort(random);
    RecordProperty("random", std::to_string(random[2]));
    RecordProperty("blocks", std::to_string(blocks));
    RecordProperty("guarded", std::to_string(guarded));
    // The reference divides the target by its STD over all clusters, here it is that of the training clusters.
    EXPECT_NEAR(blocks, blocks_reference[axis], 0.1 * blocks_reference[axis]);
    EXPECT_GE(guarded, 0.95 * blocks);
  }
}

}  // namespace
}  // namespace gyrotherm
