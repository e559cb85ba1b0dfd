// SPDX-License-Identifier: Apache-2.0
/// What errors of the thermometers make of a model's inputs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "core/result.hpp"

namespace gyrotherm::data {

/// The covariance of the inputs that thermometers of these standard uncertainties (K, one per thermometer of the
/// clusters) make, averaged over the clusters, terms × terms, unscaled:
/// Σ_q u_q² E[d_q d_qᵀ], d_q = ∂terms/∂q (GUM §5.1.2 for each cluster). It is the penalty of errors in variables: the
/// expectation of ‖y − (X + E)w‖²/n is ‖y − Xw‖²/n + wᵀ·covariance·w (Fuller, Measurement Error Models (1987), §1.2).
///
/// The quantities q are the temperatures, rates and lags that the terms are made of, each with an error of its own,
/// independent of the others': u for a temperature, and for a rate and a lag what an error u of the last mean makes of
/// them: u/length, and exp(−length/τ) u. That is the careful reading of a certificate, which does not say how much of
/// an error stays the same over a run: of a constant error rates and lags would show nothing, of one that changes with
/// the temperature as much as this.
///
/// Fails with usage if there is not one uncertainty per thermometer, one is below 0, or as evaluate.
[[nodiscard]] Result<Eigen::MatrixXd> input_covariance(const std::vector<Term>& terms, const Clusters& clusters,
                                                       const std::vector<double>& uncertainty_k);

}  // namespace gyrotherm::data
