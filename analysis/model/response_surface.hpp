// SPDX-License-Identifier: Apache-2.0
/// A response surface of second order by ridge regression: the cheap learner by which inputs are chosen and
/// thermometers are judged. Its cost is milliseconds, and on the virtual gyro its held-out error is the noise floor
/// (docs/evaluation.md).
///
/// y ≈ b + Σ w_i z_i + Σ_{i≤j} w_ij z_i z_j (Box & Wilson, J. R. Stat. Soc. B 13 (1951) 1), minimising
/// ‖y − ŷ‖² + λ n ‖w‖² with b free (Hoerl & Kennard, Technometrics 12 (1970) 55). z are the inputs standardised on the
/// training rows; so are, once more, the products. What does not vary on the training rows has no part.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "analysis/data/folds.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::model {

/// The penalties λ that try_surface chooses from.
inline constexpr std::array<double, 11> kSurfaceLambdas = {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1, 10, 100};

/// Predicts the rows of `test_x` by surfaces with these λ, learnt from `train_x` and `train_y`: rows × λ. Without a
/// column in x the prediction is the mean of `train_y`. All values are finite, λ > 0, and there is a training row.
[[nodiscard]] Eigen::MatrixXd surface_predictions(const svm::SampleMatrix& train_x, const Eigen::VectorXd& train_y,
                                                  const svm::SampleMatrix& test_x, std::span<const double> lambdas);

/// How well a surface predicts held-out folds, λ chosen by them.
struct SurfaceTrial {
  Eigen::VectorXd residual;  ///< y − ŷ of each row, in the units of y; NaN where a row is never held out
  double lambda{};
  double mean_square{};  ///< of the residuals that are
};

/// Holds each fold out in turn. `x` and `y` have a row per cluster that the folds number.
[[nodiscard]] SurfaceTrial try_surface(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                       const data::FoldPlan& folds);

}  // namespace gyrotherm::model
