// SPDX-License-Identifier: Apache-2.0
/// Estimation of one rate vector from many axes, and of the contradictions between the axes. Both use constant
/// matrices, so each second needs only two matrix products.
#pragma once

#include <Eigen/Core>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/geometry.hpp"

namespace gyrotherm::fusion {

/// The constant matrices of N axes.
struct Gains {
  /// G, 3 × N: the rate vector is G y.
  Eigen::Matrix3Xd rate;
  /// Covariance of the rate vector, (°/h)²: (Hᵀ C⁻¹ H)⁻¹.
  Eigen::Matrix3d covariance;
  /// V, (N − 3) × N: the parity vector is V y, N(0, I) while no axis has a fault.
  Eigen::MatrixXd parity;
};

/// Computes the matrices. G is the generalised least-squares estimator (Aitken, Proc. R. Soc. Edinb. 55 (1935) 42), the
/// best linear unbiased one: (Hᵀ C⁻¹ H)⁻¹ Hᵀ C⁻¹. V spans the space that no rate can reach, V H = 0, and whitens it, V
/// C Vᵀ = I (Potter and Suman, AGARDograph 224 (1977), for C = I; Sturza, Navigation 35 (1988) 483). Both are obtained
/// from one QR decomposition of L⁻¹ H, C = L Lᵀ (Golub and Van Loan, Matrix Computations, 5.3 and 6.1): with Q = (Q₁
/// Q₂), G = R⁻¹ Q₁ᵀ L⁻¹ and V = Q₂ᵀ L⁻¹. With three axes V has no rows.
[[nodiscard]] Gains compute_gains(const Geometry& geometry);

/// Computes gains with the weights of `weights`, a geometry of the same axes with another covariance. `geometry`
/// determines the covariance of the vector and the parity. If `weights` differs from `geometry`, the vector does not
/// have the least variance, but remains unbiased.
[[nodiscard]] Gains weighted_gains(const Geometry& geometry, const Geometry& weights);

struct FusedRate {
  Eigen::Vector3d deg_per_h;   ///< axes of the fixture
  Eigen::Matrix3d covariance;  ///< (°/h)²
};
/// Returns the rate vector of one reading per axis, °/h.
[[nodiscard]] FusedRate fuse_readings(const Gains& gains, const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h);

inline constexpr double kLeastRedundancy = 1e-6;

/// Returns the rate vector of the readings without one axis. With gains of compute_gains(), it equals the result with
/// the gains of compute_gains(remove_axis(…)). Leaving an axis out is equivalent to giving it an unknown bias, whose
/// estimate is v_iᵀ p/|v_i|², with v_i its column of V and p the parity vector; the contribution of this bias to G y is
/// subtracted. With gains of weighted_gains(), the vector is unbiased and independent of the reading of the axis, but
/// differs from that of the remaining axes with these weights, and its covariance omits the correlation of G y with p.
/// Fails with numeric if only this axis measures some direction, that is, if |v_i|²/(C⁻¹)_ii is below kLeastRedundancy.
[[nodiscard]] Result<FusedRate> fuse_without_axis(const Gains& gains,
                                                  const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h,
                                                  Eigen::Index axis);

/// Returns the test of the parity vector. The candidates are the axes, each with a bias in °/h.
[[nodiscard]] FaultTest parity_test(const Gains& gains, const Geometry& geometry);

}  // namespace gyrotherm::fusion
