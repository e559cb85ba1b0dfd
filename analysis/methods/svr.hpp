// SPDX-License-Identifier: Apache-2.0
/// ε-SVR tuned by particle swarm: the paper's own method (eqs. 1–10), the filter that goes before it in `svr-flp`, and
/// the plane beside it in `svr-linear`.
#pragma once

#include <Eigen/Core>

#include "analysis/data/clusters.hpp"
#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Chooses C, sigma and epsilon by tune_svr. A quick search of folds with more than 2000 training rows learns from
/// every k-th of them, at most 1000, and divides the C that it finds by k: the losses of all rows weigh as much as
/// those of the k-th did. A warning says so.
[[nodiscard]] ChooseFunction choose_svr;

/// Fits by solve_svr and fails like it. The effective parameters are the support vectors that are not at their bound
/// (Gunter, Zhu 2007).
[[nodiscard]] FitFunction fit_svr;

/// The adaptive forward linear predictor with which Cheng et al., Measurement 55 (2014) 246 (ref. 16 of the paper),
/// take the noise from the bias before they train: ŷ(n) = Σ_{k=1}^{p} a_k y(n−k), a_k += µ e(n) y(n−k), e = y − ŷ.
struct ForwardPrediction {
  int order = 8;      ///< p
  double step = 0.1;  ///< µ of the normalised form, 0 < µ < 2
};

/// Predicts ŷ(n) for each n; the first p values stay as they are, since nothing comes before them. The step is
/// normalised, µ e(n) y(n−k)/Σ_k y(n−k)²: the plain form diverges where µ Σy² exceeds 2, and the bias of a gyro can
/// have any size. It begins with a_k = 1/p, the mean of the last p. Values are finite.
[[nodiscard]] Eigen::VectorXd forward_prediction(const Eigen::Ref<const Eigen::VectorXd>& values,
                                                 const ForwardPrediction& options = {});

/// The bias of training clusters, predicted anew over each stretch of clusters without a gap, from the stretch's mean.
/// A stretch ends where a cluster is missing or another record begins. A predictor takes noise from a bias
/// that stands still; one that moves it follows no closer than the noise it takes: on the virtual rate run, with the
/// order and step that predict it best, the filtered bias lies 0.0020 °/h from a smooth fit, the raw one 0.0019.
[[nodiscard]] Eigen::VectorXd filter_bias(const data::Clusters& training);

// svr-linear: support vectors beside a plane. Ridge-u's plane, then Gaussian ε-SVR on what it leaves.
//
// A Gaussian kernel learns the path that its training walked: beyond it the function falls back to a constant, and the
// thermometers' errors are weighed by nothing. A plane goes on where the path ends, and what is left for the support
// vectors is the bend.
//
// The plane is ridge-u's (ridge_u.hpp), so that its input noise is that of the certificate in closed form: to add
// u² Σ(∂f/∂T_i)² to the loss, or to train on jittered copies of the inputs, is the same to first order (Bishop, Neural
// Comput. 7 (1995) 108), and only the closed form is exact, has nothing to draw and no copy to solve for. Plane and
// support vectors are fitted one after the other (docs/decisions/0019-the-plane-carries-the-certificate.md).

/// Chooses C, sigma and epsilon by tune_svr on what the plane of each fold's training rows leaves of the fold, in units
/// of what it leaves of them.
[[nodiscard]] ChooseFunction choose_svr_linear;

/// Fits the plane, then support vectors by fit_svr. The effective parameters are the sum of both. Fails like them.
[[nodiscard]] FitFunction fit_svr_linear;

}  // namespace gyrotherm::methods
