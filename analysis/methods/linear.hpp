// SPDX-License-Identifier: Apache-2.0
/// The methods whose function is linear in its inputs: least squares as they are, as a polynomial, stepwise, and ridge
/// regression.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Computes the variance of a plane that was fitted to the targets y at z, samples × inputs, with the penalty ‖Rw‖² on
/// its weights, R = `penalty_rows` (none: no penalty): of the weights s²(ZᵀZ + RᵀR)⁻¹, Z the centred inputs, and of the
/// value at the inputs' mean s²/n. s² is the sum of squares of what the plane leaves over n − `effective_parameters`
/// (at least 1), so residuals count as independent. A direction of the weights in which Z and R have less than 3·10⁻⁷
/// of their greatest length counts as if they had that: its variance is huge, and matters only to inputs that leave the
/// plane of the training. Units are those of z and y.
/// Source: GUM, JCGM 100:2008, H.3; the penalty as a prior: Hoerl and Kennard, Technometrics 12 (1970) 55, §5.
[[nodiscard]] PredictiveVariance coefficient_variance(const data::SampleMatrix& z, const Eigen::VectorXd& y,
                                                      const LinearModel& plane, double effective_parameters,
                                                      const Eigen::MatrixXd& penalty_rows = {});

/// Makes the fit of a plane to a set with that penalty, with its coefficient_variance().
[[nodiscard]] Fit fit_of_plane(const FitInput& set, LinearModel plane, double effective_parameters,
                               const Eigen::MatrixXd& penalty_rows = {});

/// Returns the variance of a plane over all `inputs`, of which it has only these `columns`.
[[nodiscard]] PredictiveVariance over_all_inputs(const PredictiveVariance& variance,
                                                 const std::vector<Eigen::Index>& columns, Eigen::Index inputs);

// Multiple linear regression by least squares.

/// Fits by a column-pivoted QR with a constant, which gives the shortest weights where inputs are dependent. Inputs
/// that depend on the others to one part in 10⁹ count as dependent. The effective parameters are the rank. Fails with
/// usage if there are not more samples than coefficients.
[[nodiscard]] FitFunction fit_linear;

// A polynomial in the temperature and its rate, by least squares: y = Σ_{k=0}^{m} a_k T^k (+ a_{m+1} Ṫ + a_{m+2} T Ṫ),
// the oldest compensation of ring laser gyros (Guo et al., Chin. Opt. Lett. 4 (2006) 576; Hong et al., IEEE LEOS 2008;
// refs. 3–5 of the paper).

/// Chooses "order", m of 1 … 3, and "rate terms", 0 or 1, as far as the inputs offer them, by held-out error.
[[nodiscard]] ChooseFunction choose_polynomial;

/// Takes the inputs whose number of temperatures and gradients multiplied is at most m, those with a rate only if asked
/// for; the others keep the weight 0. Fits like fit_linear: inputs are standardised powers, which is the same
/// polynomial as in T mapped to [−1, 1]. Fails with usage if no input remains.
[[nodiscard]] FitFunction fit_polynomial;

// Stepwise regression by partial F tests (Efroymson 1960); for ring laser gyros: Zhang and Long, Opt. Tech. 32 (2006)
// 738, ref. 6 of the paper.
//
// Starts empty; adds the input with the largest partial F = (RSS_old − RSS_new)/(RSS_new/(n − p − 1)), p inputs after
// adding, if F > 3.84; then drops any with F < 2.71, the least first; stops when neither happens. 3.84 and 2.71 are
// the 5 % and 10 % points of F with one and many degrees of freedom, if errors were independent, which clusters' are
// not: inputs that mean nothing may enter.

inline constexpr double kFToEnter = 3.84;
inline constexpr double kFToRemove = 2.71;

/// Nothing is chosen on held-out folds: the F tests choose. An input of which less than 10⁻⁹ of its spread is its own,
/// given those already taken, is not asked. Inputs not taken keep the weight 0; the particulars name those taken. The
/// effective parameters are those taken and the constant; that they were picked is not counted. Fails with usage if
/// there are not three samples more than inputs that enter.
[[nodiscard]] FitFunction fit_stepwise;

// Ridge regression on physics features: T, T², gradients, gradients times T, and the rate. One of the two modern
// methods beside the paper's (Hoerl and Kennard, Technometrics 12 (1970) 55).
//
// Why this one and not boosted trees: a bias that follows from heat flow is smooth in temperatures and gradients,
// which these features say to second order, and a penalised plane through them goes on sensibly beyond the trained
// range. A tree is constant between its cuts and beyond them: it would put steps into the compensated rate,
// extrapolate by standing still, and need a thousand times the numbers in a navigation computer.

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
[[nodiscard]] ChooseFunction choose_ridge;

/// Fits by minimising ‖y − Zw − b‖² + λn‖w‖². The effective parameters are the trace.
[[nodiscard]] FitFunction fit_ridge;

}  // namespace gyrotherm::methods
