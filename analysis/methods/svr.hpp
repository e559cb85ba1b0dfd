// SPDX-License-Identifier: Apache-2.0
/// ε-SVR tuned by particle swarm: the method of the paper (eqs. 1–10), the filter that precedes it in `svr-flp`, and
/// the plane added to it in `svr-linear`.
#pragma once

#include <Eigen/Core>

#include "analysis/data/clusters.hpp"
#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Chooses C, sigma and epsilon by tune_svr. If a fold has more than 2000 training rows, a quick search trains on every
/// k-th row, at most 1000. The resulting C is divided by k, which keeps the total weight of the losses. A warning
/// reports the reduction.
[[nodiscard]] ChooseFunction choose_svr;

/// Fits by solve_svr and fails as it does. The number of effective parameters is the number of support vectors that are
/// not at their bound (Gunter, Zhu 2007).
[[nodiscard]] FitFunction fit_svr;

/// Adaptive forward linear predictor of Cheng et al., Measurement 55 (2014) 246 (ref. 16 of the paper), which removes
/// noise from the bias before training: ŷ(n) = Σ_{k=1}^{p} a_k y(n−k), a_k += µ e(n) y(n−k), e = y − ŷ.
struct ForwardPrediction {
  int order = 8;      ///< p
  double step = 0.1;  ///< normalised µ, 0 < µ < 2
};

/// Predicts ŷ(n) for each n. The first p values are returned unchanged, since they have no predecessors. The step is
/// normalised, µ e(n) y(n−k)/Σ_k y(n−k)²; the plain form diverges if µ Σy² exceeds 2, and the bias of a gyro can have
/// any size. The coefficients start at a_k = 1/p, the mean of the last p values. Values must be finite.
[[nodiscard]] Eigen::VectorXd forward_prediction(const Eigen::Ref<const Eigen::VectorXd>& values,
                                                 const ForwardPrediction& options = {});

/// Filters the bias of training clusters. The predictor restarts in each stretch of clusters without a gap, with the
/// values relative to the mean of the stretch. A stretch ends at a missing cluster or at the start of another record. A
/// predictor removes noise from a constant bias. A predictor that follows a changing bias adds as much error as it
/// removes: on the virtual ramp run, with the best order and step, the filtered bias deviates from a smooth fit by
/// 0.0020 °/h and the raw bias by 0.0019 °/h.
[[nodiscard]] Eigen::VectorXd filter_bias(const data::Clusters& training);

// svr-linear: the plane of ridge-u, then Gaussian ε-SVR on its residual.
//
// A function of Gaussians alone is valid only near its training data: elsewhere it returns to a constant, and its fit
// does not consider thermometer errors. Here the plane extrapolates, and the support vectors describe only the
// curvature.
//
// The plane is fitted as in ridge-u (ridge_u.hpp), which includes the input noise of the certificate in closed form.
// Adding u² Σ(∂f/∂T_i)² to the loss, or training on jittered copies of the inputs, gives the same result to first order
// (Bishop, Neural Comput. 7 (1995) 108), but only the closed form is exact and needs no random copies. Plane and
// support vectors are fitted one after the other (docs/decisions/0019).

/// Chooses C, sigma and epsilon by tune_svr on the residual of the plane. The plane is fitted to the training rows of
/// each fold; the residual is in units of its RMS on these rows.
[[nodiscard]] ChooseFunction choose_svr_linear;

/// Fits the plane, then support vectors by fit_svr. The number of effective parameters is the sum for both parts. Fails
/// as fit_ridge_u and fit_svr do.
[[nodiscard]] FitFunction fit_svr_linear;

}  // namespace gyrotherm::methods
