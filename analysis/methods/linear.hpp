// SPDX-License-Identifier: Apache-2.0
/// Methods with functions that are linear in their inputs: plain least squares, polynomial, stepwise and ridge
/// regression.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Computes the variance of a plane fitted to the targets y at z, samples × inputs, with the penalty ‖Rw‖² on its
/// weights, R = `penalty_rows` (empty: no penalty). The variance of the weights is s²(ZᵀZ + RᵀR)⁻¹, with Z the centred
/// inputs. The variance of the value at the mean of the inputs is s²/n. s² is the residual sum of squares divided by n
/// − `effective_parameters` (at least 1). Residuals are assumed independent. Each direction of the weights has a length
/// in Z and R. Lengths below 3·10⁻⁷ of the greatest are raised to that limit. The variance along such a direction is
/// huge, which matters only for inputs that leave the plane of the training data. Units follow from the units of z and
/// y. Source: GUM, JCGM 100:2008, H.3; the penalty as a prior: Hoerl and Kennard, Technometrics 12 (1970) 55, §5.
[[nodiscard]] PredictiveVariance coefficient_variance(const data::SampleMatrix& z, const Eigen::VectorXd& y,
                                                      const LinearModel& plane, double effective_parameters,
                                                      const Eigen::MatrixXd& penalty_rows = {});

/// Makes a Fit from a plane that was fitted to `set` with the penalty ‖Rw‖², R = `penalty_rows`. Adds the
/// coefficient_variance() of the plane.
[[nodiscard]] Fit make_plane_fit(const FitInput& set, LinearModel plane, double effective_parameters,
                                 const Eigen::MatrixXd& penalty_rows = {});

/// Expands the variance of a plane in the given `columns` to all `inputs`.
[[nodiscard]] PredictiveVariance expand_to_inputs(const PredictiveVariance& variance,
                                                  const std::vector<Eigen::Index>& columns, Eigen::Index inputs);

// Multiple linear regression by least squares.

/// Fits the inputs and a constant by a complete orthogonal decomposition, which gives the shortest weights if inputs
/// are dependent. The relative threshold for dependence is 10⁻⁹. The number of effective parameters is the rank. Fails
/// with usage unless there are more samples than the rank.
[[nodiscard]] FitFunction fit_linear;

// Polynomial in the temperature and its rate, by least squares: y = Σ_{k=0}^{m} a_k T^k (+ a_{m+1} Ṫ + a_{m+2} T Ṫ),
// the oldest compensation of ring laser gyros (Guo et al., Chin. Opt. Lett. 4 (2006) 576; Hong et al., IEEE LEOS 2008;
// refs. 3–5 of the paper).

/// Chooses "order", m = 1…3, and "rate terms", 0 or 1, by held-out error among the polynomials that the inputs allow.
[[nodiscard]] ChooseFunction choose_polynomial;

/// Fits, as fit_linear does, the inputs that are products of at most m temperatures and gradients. Inputs with a rate
/// are used only if "rate terms" is 1. The other inputs get the weight 0. Inputs are standardised powers, which gives
/// the same polynomial as T mapped to [−1, 1]. Fails with usage if no input remains.
[[nodiscard]] FitFunction fit_polynomial;

// Stepwise regression by partial F tests (Efroymson 1960); for ring laser gyros: Zhang and Long, Opt. Tech. 32 (2006)
// 738, ref. 6 of the paper.
//
// Starts empty. Adds the input with the largest partial F = (RSS_old − RSS_new)/(RSS_new/(n − p − 1)) if F > 3.84; p is
// the number of inputs including the new one. Then drops inputs with F < 2.71, the lowest F first. Stops when no input
// is added. 3.84 and 2.71 are the 5 % and 10 % points of F with one and many degrees of freedom for independent errors.
// Errors of clusters are not independent, so irrelevant inputs may be added.

inline constexpr double kFToEnter = 3.84;
inline constexpr double kFToRemove = 2.71;

/// Fits by stepwise regression. The F tests select the inputs; nothing is chosen on held-out folds. An input is skipped
/// if less than 10⁻⁹ of its spread is independent of the inputs already selected. Inputs that are not selected get the
/// weight 0; the particulars list the selected inputs. The number of effective parameters is the number of selected
/// inputs plus 1 for the constant; the selection itself is not counted. Fails with usage unless there are at least
/// three samples more than selected inputs.
[[nodiscard]] FitFunction fit_stepwise;

// Ridge regression on physics features: T, T², gradients, gradients times T, and the rate. This is one of two modern
// methods added to those of the paper (Hoerl and Kennard, Technometrics 12 (1970) 55).
//
// Boosted trees are not used. A bias caused by heat flow is smooth in temperatures and gradients; these features
// describe it to second order, and a penalised plane in them extrapolates sensibly. A tree is piecewise constant: it
// would put steps into the compensated rate, extrapolate with a constant, and need a thousand times as many parameters
// in a navigation computer.

/// Ridge regression for any penalty from one decomposition. Minimises ‖y − Zw − b‖² + λn‖w‖² without a penalty on b.
class RidgePath {
 public:
  /// Decomposes z, with one sample per row. It must have at least one row and one column.
  RidgePath(const Eigen::Ref<const Eigen::MatrixXd>& z, const Eigen::Ref<const Eigen::VectorXd>& y);
  /// Returns the weights w for a penalty λ > 0.
  [[nodiscard]] Eigen::VectorXd weights(double lambda) const;
  /// Returns the constant b for these weights.
  [[nodiscard]] double offset(const Eigen::VectorXd& weights) const;
  /// Returns the trace of the matrix from y to fitted values, including 1 for the constant.
  [[nodiscard]] double effective_parameters(double lambda) const;

 private:
  Eigen::RowVectorXd z_mean_;
  double y_mean_{};
  double samples_{};
  /// Singular values and right singular vectors of the centred Z.
  Eigen::VectorXd singular_;
  Eigen::MatrixXd right_;
  /// Coordinates of y in the left singular vectors.
  Eigen::VectorXd target_;
};

/// Chooses "lambda" from 10⁻⁸ … 10² in decades by held-out error.
[[nodiscard]] ChooseFunction choose_ridge;

/// Fits by minimising ‖y − Zw − b‖² + λn‖w‖². The number of effective parameters is the trace of the matrix from y to
/// fitted values.
[[nodiscard]] FitFunction fit_ridge;

}  // namespace gyrotherm::methods
