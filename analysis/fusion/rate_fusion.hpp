// SPDX-License-Identifier: Apache-2.0
/// One rate vector from many axes, and what the axes say against each other: two matrices that never change, so that a
/// second's work is two products.
#pragma once

#include <Eigen/Core>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/geometry.hpp"

namespace gyrotherm::fusion {

/// The two matrices of N axes.
struct Gains {
  Eigen::Matrix3Xd rate;       ///< G, 3 × N: the rate vector is G y
  Eigen::Matrix3d covariance;  ///< of that vector, (°/h)²: (Hᵀ C⁻¹ H)⁻¹
  Eigen::MatrixXd parity;      ///< V, (N − 3) × N: the parity vector is V y, N(0, I) while no axis is at fault
};

/// G is the generalised least-squares estimator (Aitken, Proc. R. Soc. Edinb. 55 (1935) 42), the best linear unbiased
/// one: (Hᵀ C⁻¹ H)⁻¹ Hᵀ C⁻¹. V spans what no rate can reach, V H = 0, and whitens it, V C Vᵀ = I (Potter and Suman,
/// AGARDograph 224 (1977), for C = I; Sturza, Navigation 35 (1988) 483). Both come of one QR decomposition of L⁻¹ H,
/// C = L Lᵀ (Golub and Van Loan, Matrix Computations, 5.3 and 6.1): with Q = (Q₁ Q₂), G = R⁻¹ Q₁ᵀ L⁻¹ and V = Q₂ᵀ L⁻¹.
/// Three axes have no parity: V has no rows.
[[nodiscard]] Gains gains_of(const Geometry& geometry);

/// The gains of readings that are weighed as `weights` has it, a geometry of the same axes with another covariance; the
/// covariance of the vector and the parity are of `geometry`. With other weights than its own the vector is not that of
/// least variance in this very geometry, and is without bias all the same.
[[nodiscard]] Gains gains_weighed_by(const Geometry& geometry, const Geometry& weights);

struct FusedRate {
  Eigen::Vector3d deg_per_h;   ///< in the axes of the fixture
  Eigen::Matrix3d covariance;  ///< (°/h)²
};
/// The rate vector of one reading per axis, °/h.
[[nodiscard]] FusedRate fused(const Gains& gains, const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h);

inline constexpr double kLeastRedundancy = 1e-6;

/// The rate vector of the same readings without one axis, as gains_of(without(…)) has it: an axis that is left out is
/// one with a bias that nobody knows, whose estimate is v_iᵀ p/|v_i|², v_i its column of V and p the parity vector; its
/// part of G y is taken back. Fails with numeric if the axis is alone in some direction: of what it tells, |v_i|² over
/// (C⁻¹)_ii, the others know less than kLeastRedundancy.
[[nodiscard]] Result<FusedRate> fused_without(const Gains& gains,
                                              const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h,
                                              Eigen::Index axis);

/// The test whose vector is the parity vector and whose candidates are the axes, each by a bias in °/h.
[[nodiscard]] FaultTest parity_test(const Gains& gains, const Geometry& geometry);

}  // namespace gyrotherm::fusion
