// SPDX-License-Identifier: Apache-2.0
/// Axes at rest on the Earth, with the Earth's rotation as their only input: estimation of their biases, of the
/// fixture's attitude and of north. The local axes are north, east and down.
#pragma once

#include <Eigen/Core>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/geometry.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "core/result.hpp"

namespace gyrotherm::fusion {

/// Attitude of the fixture and its standard uncertainties.
struct Attitude {
  /// Rotation from the axes of the fixture to north, east, down.
  Eigen::Matrix3d to_local = Eigen::Matrix3d::Identity();
  double tilt_std_deg{};     ///< about north and about east, each
  double azimuth_std_deg{};  ///< about down
  double latitude_deg{};
  double latitude_std_deg{};
  /// Additional covariance of the angles about north, east and down, deg², such as that caused by the fixture's
  /// elevation and roll.
  Eigen::Matrix3d turn_covariance_deg2 = Eigen::Matrix3d::Zero();
};

/// Returns the covariance of the fixture's angles about north, east and down, rad², without the latitude.
[[nodiscard]] Eigen::Matrix3d pose_covariance(const Attitude& attitude);

/// Returns the attitude of a level fixture with this heading of its first axis; the third axis points down.
[[nodiscard]] Eigen::Matrix3d level_fixture(double heading_deg);

/// Returns the Earth's rotation in north, east, down, °/h: Ω (cos φ, 0, −sin φ), Ω = 7.292115e-5 rad/s (WGS 84).
[[nodiscard]] Eigen::Vector3d earth_rate(double latitude_deg);

/// Prior of the biases. For axes with thermal compensation: mean 0 and the covariance of their budgets, with the errors
/// that axes share as off-diagonal elements.
struct BiasPrior {
  Eigen::VectorXd mean_deg_per_h;
  Eigen::MatrixXd covariance;  ///< (°/h)²
};

/// Joint estimate of biases and rotation; covariances are posterior.
struct RestEstimate {
  Eigen::VectorXd bias_deg_per_h;   ///< one per axis
  Eigen::MatrixXd bias_covariance;  ///< (°/h)²
  /// ψ; the attitude is exp([ψ×]) to_local.
  Eigen::Vector3d rotation_rad;
  Eigen::Matrix3d rotation_covariance;  ///< rad²
  /// Covariance of biases (rows) and rotation, °/h · rad.
  Eigen::MatrixXd cross_covariance;
  /// Contradiction of readings and priors: χ² with one degree of freedom per axis if all are correct.
  double statistic{};
  int iterations{};
};

/// Solves y = H to_localᵀ exp(−[ψ×]) Ω + b + e for b and ψ. Maximises their probability by the update of the iterated
/// Kalman filter, which is a Gauss-Newton method (Bell and Cathey, IEEE Trans. Autom. Control 38 (1993) 294); the
/// exponential map is differentiated with respect to ψ at ψ, not at 0. A prior covariance may be 0; the quantity then
/// keeps its prior value. The error e of the readings has the covariance of `geometry`; the readings should be
/// sufficiently long means.
///
/// N axes cannot determine N biases and three angles; the priors determine how a difference is divided between biases
/// and angles. A rotation about the Earth's axis is not observable. An uncertain latitude is treated as a further tilt
/// about east, since both are small: their variances are added, and the estimated rotation is the sum of both. Scale
/// factors are assumed to be exact: 10 ppm are 1.5e-4 °/h.
///
/// Fails with usage if a size does not match, a number is not finite, a standard deviation is negative, the latitude is
/// outside ± 90°, or to_local is not a rotation; with numeric if the iteration does not converge.
[[nodiscard]] Result<RestEstimate> estimate_at_rest(const Geometry& geometry,
                                                    const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h,
                                                    const Attitude& attitude, const BiasPrior& prior);

/// Fault test of axes at rest; three axes are sufficient. The vector is W (y − H to_localᵀ Ω − b₀), where W whitens its
/// covariance C + B + J P Jᵀ, to first order in the angles. Each axis is a candidate.
struct RestTest {
  Eigen::MatrixXd whitening;           ///< W
  Eigen::VectorXd expected_deg_per_h;  ///< expected readings, subtracted first
  FaultTest test;
};
/// Computes the test. Fails like estimate_at_rest().
[[nodiscard]] Result<RestTest> rest_test(const Geometry& geometry, const Attitude& attitude, const BiasPrior& prior);

/// The heading of a level fixture at rest, and its uncertainty.
struct North {
  /// Heading of the first axis from north over east, above −180° and at most 180°.
  double heading_deg{};
  double standard_deg{};  ///< u
  double expanded_deg{};  ///< U, 95 %, k = 1.96
};

/// Standard uncertainties of the tilt of a nominally level fixture.
struct Tilt {
  double about_north_deg{}, about_east_deg{};
};

/// Finds north from the Earth's rotation: the heading is atan2(−ω₂, ω₁). The horizontal part of the Earth's rotation, Ω
/// cos φ, gives a fixture with heading ψ the rates Ω cos φ cos ψ on its first axis and −Ω cos φ sin ψ on its second. To
/// first order, the error of the heading is that of the rate towards east over Ω cos φ, and a tilt about north times
/// tan φ (Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed. 2004, chapter 10, on gyrocompass
/// alignment): u² = (eᵀ Σ e)/(Ω cos φ)² + (u_tilt tan φ)², with u_tilt about north, e the direction of east in the
/// fixture and Σ the covariance of the rate.
///
/// The rate must be measured at rest, and its covariance must include the uncertainty of the biases; the fixture's
/// third axis points down except for the tilt. Fails with usage if the latitude is outside ± 90° or an uncertainty of
/// the tilt is negative. Fails with numeric if the horizontal rate is less than ten times its uncertainty towards east
/// (as near a pole), since a first-order formula is then not sufficient; or if it differs from Ω cos φ by more than ten
/// times its own uncertainty and that of the tilt, since the fixture is then not at rest or not at that latitude.
[[nodiscard]] Result<North> find_north(const FusedRate& rate, double latitude_deg, const Tilt& tilt);

}  // namespace gyrotherm::fusion
