// SPDX-License-Identifier: Apache-2.0
/// ε-SVR tuned by particle swarm: the paper's own method (eqs. 1–10), and the filter that goes before it in `svr-flp`.
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

}  // namespace gyrotherm::methods
