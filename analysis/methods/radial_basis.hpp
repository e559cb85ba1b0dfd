// SPDX-License-Identifier: Apache-2.0
/// Radial basis function network with k-means centres (Moody and Darken, Neural Comput. 1 (1989) 281): the network of
/// Jin et al. 2008 and Yu et al. 2012 (refs. 8 and 10 of the paper) and what Ding et al., Sensors 14 (2014) 18711,
/// compare theirs with.
///
/// ŷ = w_0 + Σ_{k=1}^{K} w_k exp(−‖z − c_k‖²/(2 s_k²)); c_k by k-means++ and Lloyd, s_k the mean distance to the two
/// nearest centres, w by ridge regression.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "analysis/methods/method.hpp"
#include "analysis/svm/svr.hpp"
#include "core/result.hpp"

namespace gyrotherm::methods {

/// Centres of clusters of samples.
struct KMeans {
  data::SampleMatrix centres;
  std::vector<double> costs;  ///< Σ of squared distances to the nearest centre, per round of Lloyd
};

/// Finds centres by k-means++ (Arthur and Vassilvitskii 2007), then Lloyd's rounds until no sample changes its centre,
/// or 200 rounds. Fails with usage if there are fewer than `count` different samples.
[[nodiscard]] Result<KMeans> k_means(const data::SampleMatrix& samples, int count, std::uint64_t seed);

/// The mean distance of each centre to its two nearest others; there are three at least.
[[nodiscard]] Eigen::VectorXd neighbour_distances(const data::SampleMatrix& centres);

/// What units at these centres with these widths make of samples: exp(−‖z_i − c_k‖²/(2 s_k²)), samples × centres.
[[nodiscard]] Eigen::MatrixXd gaussian_units(const data::SampleMatrix& samples, const data::SampleMatrix& centres,
                                             const Eigen::VectorXd& widths);

/// Chooses "centres", K of 10, 20, 40, 80, and "lambda" of 10⁻¹⁰ … 10⁻² in steps of two decades, by held-out error.
[[nodiscard]] Result<Choice> choose_radial_basis(std::span<const Fold> folds, const MethodOptions& options,
                                                 const ProgressSink& progress);

/// The effective parameters are the trace for these centres; that they were placed is not counted. Fails with usage if
/// there are fewer different samples than centres.
[[nodiscard]] Result<Fit> fit_radial_basis(const FitInput& set, const HyperParameters& parameters,
                                           const MethodOptions& options);

}  // namespace gyrotherm::methods
