// SPDX-License-Identifier: Apache-2.0
/// Sums of Gaussians at their own centres: the response of a training set to its β, each pair's Gaussian made once.
#pragma once

#include <Eigen/Core>

#include "analysis/svm/gaussian_loops.hpp"
#include "analysis/svm/svr.hpp"

namespace gyrotherm::svm {

/// Σ_j β_j exp(−‖x_i − x_j‖²/(2σ²)) at each sample x_i, a row of `x` in coordinates that are `spanned`, from the
/// non-zero β alone. Against the formula the error is below 1e-11 Σ|β_j|, as of a GaussianSum, which takes its place
/// where samples lie too far apart for products.
[[nodiscard]] Eigen::VectorXd gaussian_response(const Eigen::Ref<const SampleMatrix>& x, double sigma,
                                                const Eigen::VectorXd& beta,
                                                const GaussianLoops& loops = gaussian_loops());

}  // namespace gyrotherm::svm
