// SPDX-License-Identifier: Apache-2.0
/// Tuning by descents along the gradient of the held-out error: BFGS in a trust region inside the box of the swarm.
#pragma once

#include "bench/tuning/fold_errors.hpp"

namespace gyrotherm::bench {

struct DescentOptions {
  /// Number of positions that are evaluated first: C = 3 STD, σ = √(d/2), ε = 2⁻⁴ STD, and a Halton sequence.
  int screened = 24;
  /// Number of descents, from the best screened positions.
  int descents = 6;
  int most_evaluations = 60;
  double first_radius_octaves = 2;
  /// A descent ends at this radius, or if its model of the error predicts less gain.
  double least_radius_octaves = 0.05;
  double least_gain = 3e-4;
};

struct DescentResult {
  Position best = Position::Zero();
  double log_error{};
};

/// Returns the step with the least value of gᵀs + ½sᵀBs in the box `lower` ≤ s ≤ `upper`, which must contain 0. The
/// minimum of a box lies inside one of its faces, so all 27 faces are compared.
[[nodiscard]] Eigen::Vector3d best_step(const Eigen::Vector3d& slope, const Eigen::Matrix3d& curvature,
                                        const Eigen::Vector3d& lower, const Eigen::Vector3d& upper);

/// Tunes within the box of svm::TuningOptions. All descents take turns, step by step. The result is a function of the
/// folds and the options. A position without a certificate is treated as worse than all others.
[[nodiscard]] DescentResult descend(FoldErrors& errors, const DescentOptions& options);

}  // namespace gyrotherm::bench
