/// How the points of an overlapping Allan curve vary together.
#pragma once

#include <Eigen/Core>

#include "analysis/data/allan.hpp"

namespace gyrotherm {

/// Squares of Q (in °), N, B, K and R, with τ in h and σ in °/h.
using NoiseSquares = Eigen::Vector<double, 5>;

/// What each square is multiplied by in σ²(τ): 3/τ², 1/τ, 2 ln 2/π, τ/3, τ²/2.
[[nodiscard]] NoiseSquares noise_shapes(double tau_h);

/// Covariance of the Allan variances of `curve`, in (°/h)⁴, for Gaussian noise of these squares over stretches as long
/// as those of `rates`.
///
/// The angle θ has the generalised covariance g(t) = Q²δ(t) − N²|t|/2 + B²t² ln|t|/(2π) + K²|t|³/12: that of its second
/// differences over m and m' samples, a lag l apart, is c(l) = Σ w_a w_b g(l + a·m − b·m'), w = (1, −2, 1); the drift R
/// adds the mean μ_m = R(mτ_0)². The mean squares of two such differences have the covariance
/// Σ over all pairs of (2c² + 4μ_m μ_m' c), divided by the numbers of both.
[[nodiscard]] Eigen::MatrixXd allan_covariance(const AllanCurve& curve, const RateStretches& rates,
                                               const NoiseSquares& squares);

}  // namespace gyrotherm
