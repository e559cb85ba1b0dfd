// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "analysis/methods/ridge_u.hpp"
#include "analysis/population/coregionalised_gp.hpp"
#include "analysis/population/multi_output_ridge.hpp"
#include "analysis/population/residual_correlation.hpp"
#include "bench/shared/sections.hpp"

namespace gyrotherm::bench {
namespace {

constexpr std::array kCorrelations = {0.0, 0.5, 0.8, 0.95};
constexpr Eigen::Index kAxes = 3;

Eigen::MatrixXd normal_draws(Eigen::Index rows, Eigen::Index columns, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Returns a matrix of equal correlations.
Eigen::MatrixXd equal_correlations(double correlation) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Constant(kAxes, kAxes, correlation);
  all.diagonal().setOnes();
  return all;
}

/// Errors for three axes that drift together over 80 cluster means. The noise is half as large as the drift. The first
/// axis has no means in the middle.
struct GapDraw {
  double p_all{}, alone{}, together{}, held{};
};

Result<GapDraw> draw_gap(double correlation, std::uint64_t seed) {
  constexpr Eigen::Index kRows = 80, kGapFrom = 30, kGapTo = 50;
  constexpr double kLength = 8, kNoise = 0.5;
  std::mt19937_64 random(seed);
  data::SampleMatrix time(kRows, 1);
  for (Eigen::Index k = 0; k < kRows; ++k) time(k, 0) = static_cast<double>(k) / kLength;
  Eigen::MatrixXd covariance(kRows, kRows);
  for (Eigen::Index i = 0; i < kRows; ++i)
    for (Eigen::Index j = 0; j < kRows; ++j)
      covariance(i, j) = std::exp(-0.5 * std::pow(time(i, 0) - time(j, 0), 2)) + (i == j ? 1e-9 : 0);
  const Eigen::MatrixXd of_time = covariance.llt().matrixL(), of_axes = equal_correlations(correlation).llt().matrixL();
  const Eigen::MatrixXd truth = of_time * normal_draws(kRows, kAxes, random) * of_axes.transpose();
  const Eigen::MatrixXd seen = truth + kNoise * normal_draws(kRows, kAxes, random);
  GapDraw draw;
  draw.p_all =
      population::correlate_residuals({.axes = {"x", "y", "z"},
                                       .places = Eigen::VectorXi::LinSpaced(kRows, 0, static_cast<int>(kRows) - 1),
                                       .residual_deg_per_h = seen})
          .all_probability;
  Eigen::MatrixXd table = seen;
  table.col(0).segment(kGapFrom, kGapTo - kGapFrom).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto together = population::learn_coregionalised(population::samples_from_table(time, table));
  const auto alone = population::learn_coregionalised(population::samples_from_table(time, table.leftCols(1)));
  if (!together || !alone) return failure(together ? alone.error() : together.error());
  const data::SampleMatrix gap = time.middleRows(kGapFrom, kGapTo - kGapFrom);
  const Eigen::VectorXd wanted = truth.col(0).segment(kGapFrom, kGapTo - kGapFrom);
  const auto by_all = predict(*together, gap), by_one = predict(*alone, gap);
  const Eigen::VectorXd error = by_all.mean.col(0) - wanted;
  draw.together = root_mean_square(error);
  draw.alone = root_mean_square(by_one.mean.col(0) - wanted);
  draw.held = (error.array().square() <= 4 * by_all.variance.col(0).array()).cast<double>().mean();
  return draw;
}

Result<void> print_gaps() {
  constexpr int kDraws = 40;
  fmt::print(
      "\nThree axes with a common wander (STD 1, noise 0.5), 80 means, {} draws. The first axis has a gap of 20 "
      "means:\n\n"
      "| correlation | p of all < 0.05 | error alone | together | difference | within 2 STD "
      "|\n|---|---|---|---|---|---|\n",
      kDraws);
  for (const double correlation : kCorrelations) {
    std::vector<double> alone, together, less, held, found;
    for (int seed = 1; seed <= kDraws; ++seed) {
      const auto draw = draw_gap(correlation, static_cast<std::uint64_t>(seed));
      if (!draw) return failure(draw.error());
      alone.push_back(draw->alone);
      together.push_back(draw->together);
      less.push_back(draw->together - draw->alone);
      held.push_back(draw->held);
      found.push_back(draw->p_all < 0.05 ? 1 : 0);
    }
    const auto difference = mean_with_error(less);
    fmt::print("| {} | {:.0f} % | {:.2f} | {:.2f} | {:+.2f} ± {:.2f} | {:.0f} % |\n", correlation,
               100 * mean_with_error(found).mean, mean_with_error(alone).mean, mean_with_error(together).mean,
               difference.mean, difference.error, 100 * mean_with_error(held).mean);
    std::fflush(stdout);
  }
  return {};
}

/// Errors, over the fitted inputs, of planes fitted to three axes with independent slopes.
struct PlaneDraw {
  double separate{}, together{}, known{};
};

Result<PlaneDraw> draw_planes(double correlation, Eigen::Index rows, std::uint64_t seed) {
  constexpr Eigen::Index kInputs = 8;
  constexpr double kNoise = 2;
  std::mt19937_64 random(seed);
  const Eigen::MatrixXd z = normal_draws(rows, kInputs, random);
  const Eigen::MatrixXd slopes = normal_draws(kInputs, kAxes, random);
  const Eigen::MatrixXd noise = kNoise * kNoise * equal_correlations(correlation);
  const Eigen::MatrixXd y =
      z * slopes + normal_draws(rows, kAxes, random) * Eigen::MatrixXd(noise.llt().matrixL()).transpose();
  const Eigen::MatrixXd penalty = Eigen::MatrixXd::Identity(kInputs, kInputs) / static_cast<double>(rows);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(kAxes, kAxes);
  const Eigen::MatrixXd alone = kNoise * kNoise * identity;
  const auto separate = population::multi_output_ridge(z, y, penalty, {alone, identity});
  const auto known = population::multi_output_ridge(z, y, penalty, {noise, identity});
  const auto together = population::multi_output_ridge(z, y, penalty);
  if (!separate || !known || !together) return failure(FaultKind::numeric, "synthetic", "a plane cannot be fitted");
  const auto error = [&](const Eigen::MatrixXd& weights) {
    return std::sqrt((weights - slopes).squaredNorm() / static_cast<double>(slopes.size()));
  };
  return PlaneDraw{error(separate->weights), error(together->planes.weights), error(known->weights)};
}

Result<void> print_planes() {
  constexpr int kDraws = 400;
  fmt::print(
      "\nRMS error of the slopes for three axes with 8 inputs, independent slopes N(0, 1) and noise of STD 2, {} "
      "draws:\n\n| correlation of the noise | rows | separate ridges | together, Ω estimated | difference | Ω known | "
      "difference |\n"
      "|---|---|---|---|---|---|---|\n",
      kDraws);
  for (const double correlation : kCorrelations) {
    for (const Eigen::Index rows : {20, 60, 500}) {
      std::vector<double> separate, together, known, less, less_known;
      for (int seed = 1; seed <= kDraws; ++seed) {
        const auto draw = draw_planes(correlation, rows, static_cast<std::uint64_t>(seed));
        if (!draw) return failure(draw.error());
        separate.push_back(draw->separate);
        together.push_back(draw->together);
        known.push_back(draw->known);
        less.push_back(draw->together - draw->separate);
        less_known.push_back(draw->known - draw->separate);
      }
      const auto difference = mean_with_error(less), of_known = mean_with_error(less_known);
      fmt::print("| {} | {} | {:.3f} | {:.3f} | {:+.4f} ± {:.4f} | {:.3f} | {:+.4f} ± {:.4f} |\n", correlation, rows,
                 mean_with_error(separate).mean, mean_with_error(together).mean, difference.mean, difference.error,
                 mean_with_error(known).mean, of_known.mean, of_known.error);
    }
  }
  return {};
}

}  // namespace

Result<void> measure_synthetic() {
  if (const auto shown = print_gaps(); !shown) return shown;
  return print_planes();
}

}  // namespace gyrotherm::bench
