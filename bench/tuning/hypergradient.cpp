// SPDX-License-Identifier: Apache-2.0
#include "bench/tuning/hypergradient.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "analysis/svm/cholesky.hpp"
#include "analysis/svm/lanes.hpp"

namespace gyrotherm::bench {
namespace {

Eigen::MatrixXd squared_distances(const svm::SampleMatrix& a, const svm::SampleMatrix& b) {
  Eigen::MatrixXd squared = -2 * (a * b.transpose());
  squared.colwise() += a.rowwise().squaredNorm();
  squared.rowwise() += b.rowwise().squaredNorm().transpose();
  return squared.cwiseMax(0.0);
}

/// Kernel between two sets of samples, and its derivative with respect to ln σ.
struct KernelBlock {
  Eigen::MatrixXd values, slopes;
};

KernelBlock make_block(const svm::SampleMatrix& a, const svm::SampleMatrix& b, double sigma) {
  const Eigen::MatrixXd squared = squared_distances(a, b);
  KernelBlock block{Eigen::MatrixXd(squared.rows(), squared.cols()), {}};
  svm::exponentiate(squared.data(), squared.size(), -0.5 / (sigma * sigma), block.values.data());
  block.slopes = block.values.cwiseProduct(squared) / (sigma * sigma);
  return block;
}

/// Factors K_FF with the least ridge that makes it positive definite in double precision.
Eigen::MatrixXd factor_free(const Eigen::MatrixXd& kernel) {
  constexpr double kLeastRidge = 1e-10, kRidgeGrowth = 100;
  for (double ridge = kLeastRidge;; ridge *= kRidgeGrowth) {
    Eigen::MatrixXd factor = kernel;
    factor.diagonal().array() += ridge;
    if (svm::factor_cholesky(factor)) return factor;
  }
}

}  // namespace

svm::SvrParameters parameters_at(const Position& position) {
  return {.C = std::exp2(position[0]), .sigma = std::exp2(position[1]), .epsilon = std::exp2(position[2])};
}

SquaredError differentiate(const SplitSamples& samples, const svm::SvrSolution& solution,
                           const svm::SvrParameters& parameters) {
  std::vector<Eigen::Index> free, bound;
  for (const Eigen::Index i : svm::support_rows(solution.beta))
    (std::abs(solution.beta[i]) < parameters.C ? free : bound).push_back(i);
  std::vector<Eigen::Index> support = free;
  support.insert(support.end(), bound.begin(), bound.end());
  const auto free_count = static_cast<Eigen::Index>(free.size()), bound_count = static_cast<Eigen::Index>(bound.size());
  const svm::SampleMatrix at_support = samples.training(support, Eigen::all);
  const Eigen::VectorXd beta = solution.beta(support), free_signs = solution.beta(free).array().sign(),
                        bound_signs = solution.beta(bound).array().sign();

  const KernelBlock held_out = make_block(samples.held_out, at_support, parameters.sigma);
  const Eigen::VectorXd residual = (held_out.values * beta).array() + solution.b - samples.held_out_y.array();
  SquaredError error{.sum = residual.squaredNorm()};
  Position slope(2 * residual.dot(held_out.values.rightCols(bound_count) * bound_signs),
                 2 * residual.dot(held_out.slopes * beta), 0);
  if (free_count > 0) {
    const KernelBlock inside = make_block(samples.training(free, Eigen::all), at_support, parameters.sigma);
    Eigen::MatrixXd sides(free_count, 2);
    sides.col(0) = held_out.values.leftCols(free_count).transpose() * (2 * residual);
    sides.col(1).setOnes();
    svm::solve_cholesky(factor_free(inside.values.leftCols(free_count)), sides);
    const double offset = (sides.col(0).sum() - 2 * residual.sum()) / sides.col(1).sum();
    const Eigen::VectorXd multipliers = sides.col(0) - offset * sides.col(1);
    slope[0] -= multipliers.dot(inside.values.rightCols(bound_count) * bound_signs) + offset * bound_signs.sum();
    slope[1] -= multipliers.dot(inside.slopes * beta);
    slope[2] -= multipliers.dot(free_signs);
  }
  error.slope = std::numbers::ln2 * slope.cwiseProduct(Position(parameters.C, 1, parameters.epsilon));
  return error;
}

}  // namespace gyrotherm::bench
