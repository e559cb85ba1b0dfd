// SPDX-License-Identifier: Apache-2.0
/// Ridge regression on physics features: T, T², gradients, gradients times T, and the rate. One of the two modern
/// methods beside the paper's (Hoerl and Kennard, Technometrics 12 (1970) 55).
///
/// Why this one and not boosted trees: a bias that follows from heat flow is smooth in temperatures and gradients,
/// which these features say to second order, and a penalised plane through them goes on sensibly beyond the trained
/// range. A tree is constant between its cuts and beyond them: it would put steps into the compensated rate,
/// extrapolate by standing still, and need a thousand times the numbers in a navigation computer.
#pragma once

#include <Eigen/Core>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Ridge regression for any penalty from one decomposition: it minimises ‖y − Zw − b‖² + λn‖w‖², b free.
class RidgePath {
 public:
  /// Rows of z are samples; there is at least one of them and one column.
  RidgePath(const Eigen::Ref<const Eigen::MatrixXd>& z, const Eigen::Ref<const Eigen::VectorXd>& y);
  /// The weights w for a penalty λ > 0.
  [[nodiscard]] Eigen::VectorXd weights(double lambda) const;
  /// The constant b that belongs to these weights.
  [[nodiscard]] double offset(const Eigen::VectorXd& weights) const;
  /// The trace of the matrix from y to fitted values, the constant's 1 included.
  [[nodiscard]] double effective_parameters(double lambda) const;

 private:
  Eigen::RowVectorXd z_mean_;
  double y_mean_{};
  double samples_{};
  Eigen::VectorXd singular_;  ///< values of the centred Z
  Eigen::MatrixXd right_;     ///< its right singular vectors
  Eigen::VectorXd target_;    ///< y in its left singular vectors
};

/// Chooses "lambda" among 10⁻⁸ … 10² in decades, by held-out error.
[[nodiscard]] Result<Choice> choose_ridge(std::span<const Fold> folds, const MethodOptions& options,
                                          const ProgressSink& progress);

/// Fits by minimising ‖y − Zw − b‖² + λn‖w‖². The effective parameters are the trace.
[[nodiscard]] Result<Fit> fit_ridge(const FitInput& set, const HyperParameters& parameters,
                                    const MethodOptions& options);

}  // namespace gyrotherm::methods
