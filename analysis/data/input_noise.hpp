// SPDX-License-Identifier: Apache-2.0
/// Propagation of thermometer errors to the inputs of a model.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "core/result.hpp"

namespace gyrotherm::data {

/// Computes the covariance of the input errors caused by thermometers with the given standard uncertainties (K, one per
/// thermometer of the clusters). The result is a mean over the clusters, terms × terms, for unscaled inputs: Σ_q u_q²
/// E[d_q d_qᵀ], d_q = ∂terms/∂q (GUM §5.1.2 for each cluster). This is the penalty matrix of errors in variables: the
/// expectation of ‖y − (X + E)w‖²/n is ‖y − Xw‖²/n + wᵀ·covariance·w (Fuller, Measurement Error Models (1987), §1.2).
///
/// The quantities q are the temperatures, rates and lags in the terms. Their errors are taken as independent. The error
/// is u for a temperature, u/length for a rate and exp(−length/τ) u for a lag, the effect of an error u of the last
/// mean. This is conservative: a certificate does not state how much of an error is constant over a run. A constant
/// error has no effect on rates and lags; an error that changes with the temperature has at most this effect.
///
/// Fails with usage if there is not one uncertainty per thermometer, or if one is negative. Fails as evaluate does.
[[nodiscard]] Result<Eigen::MatrixXd> input_covariance(const std::vector<Term>& terms, const Clusters& clusters,
                                                       const std::vector<double>& uncertainty_k);

}  // namespace gyrotherm::data
