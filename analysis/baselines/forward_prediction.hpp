/// The adaptive forward linear predictor with which Cheng et al., Measurement 55 (2014) 246 (ref. 16 of the paper),
/// take the noise from the bias before they train: ŷ(n) = Σ_{k=1}^{p} a_k y(n−k), a_k += µ e(n) y(n−k), e = y − ŷ.
#pragma once

#include <Eigen/Core>

#include "analysis/clusters.hpp"

namespace gyrotherm {

struct ForwardPrediction {
  int order = 8;      ///< p
  double step = 0.1;  ///< µ of the normalised form, 0 < µ < 2
};

/// ŷ(n) for each n; the first p values stay as they are, since nothing comes before them. The step is normalised,
/// µ e(n) y(n−k)/(ε + Σ_k y(n−k)²): the plain form diverges where µ Σy² exceeds 2, and the bias of a gyro can have any
/// size. It begins with a_k = 1/p, the mean of the last p. Values are finite.
[[nodiscard]] Eigen::VectorXd forward_prediction(const Eigen::Ref<const Eigen::VectorXd>& values,
                                                 const ForwardPrediction& options = {});

/// The bias of training clusters, predicted anew over each stretch of clusters without a gap, from the stretch's mean.
/// A stretch ends where a cluster is missing or another record begins. The prediction lags a bias that moves: it is
/// part of the published method, and the reason why other methods do without.
[[nodiscard]] Eigen::VectorXd filter_bias(const Clusters& training);

}  // namespace gyrotherm
