// SPDX-License-Identifier: Apache-2.0
/// Axes at rest on the Earth, whose rotation is then the one rate they may see: what it says of their biases, of how
/// the fixture stands and of where north is. The local axes are north, east and down.
#pragma once

#include <Eigen/Core>

#include "analysis/fusion/fault_test.hpp"
#include "analysis/fusion/geometry.hpp"
#include "analysis/fusion/rate_fusion.hpp"
#include "core/result.hpp"

namespace gyrotherm::fusion {

/// How the fixture stands, and how well that is known; standard uncertainties.
struct Attitude {
  Eigen::Matrix3d to_local = Eigen::Matrix3d::Identity();  ///< from the fixture to north, east, down: a rotation
  double tilt_std_deg{};                                   ///< about north, and about east
  double azimuth_std_deg{};                                ///< about down
  double latitude_deg{};
  double latitude_std_deg{};
  /// The covariance of the angles about north, east and down that is added to these, as a fixture's elevation and roll
  /// make it; deg².
  Eigen::Matrix3d turn_covariance_deg2 = Eigen::Matrix3d::Zero();
};

/// Returns the covariance of the angles by which the fixture is turned about north, east and down, rad², without the
/// latitude.
[[nodiscard]] Eigen::Matrix3d pose_covariance(const Attitude& attitude);

/// The attitude of a level fixture whose first axis has this heading and whose third points down.
[[nodiscard]] Eigen::Matrix3d level_fixture(double heading_deg);

/// The Earth's rotation in north, east, down, °/h: Ω (cos φ, 0, −sin φ), Ω = 7.292115e-5 rad/s (WGS 84).
[[nodiscard]] Eigen::Vector3d earth_rate(double latitude_deg);

/// What is known of the biases beforehand: for axes that their thermal models compensate, mean 0 and what the budgets
/// say, with what the axes share beside the diagonal.
struct BiasPrior {
  Eigen::VectorXd mean_deg_per_h;
  Eigen::MatrixXd covariance;  ///< (°/h)²
};

/// Biases and rotation together; covariances are those after the readings.
struct RestEstimate {
  Eigen::VectorXd bias_deg_per_h;       ///< of each axis
  Eigen::MatrixXd bias_covariance;      ///< (°/h)²
  Eigen::Vector3d rotation_rad;         ///< ψ: the fixture stands as exp([ψ×]) to_local says
  Eigen::Matrix3d rotation_covariance;  ///< rad²
  Eigen::MatrixXd cross_covariance;     ///< of biases (rows) and rotation, °/h · rad
  double statistic{};  ///< what readings and priors are at odds: χ² with a degree of freedom per axis if all is well
  int iterations{};
};

/// Solves y = H to_localᵀ exp(−[ψ×]) Ω + b + e for b and ψ: the maximum of their probability by the update of the
/// iterated Kalman filter, which is a Gauss-Newton method (Bell and Cathey, IEEE Trans. Autom. Control 38 (1993) 294);
/// the derivative by ψ is that of the exponential map, not that at 0. Priors may be 0: what is then known stays as it
/// is. The readings' own error e has the geometry's covariance, and should be of means long enough for it.
///
/// N axes cannot tell N biases and three angles apart: what becomes of them is the weight of the priors. About the
/// Earth's axis nothing is seen. An uncertain latitude is one more tilt about east, as small as it is: their squares
/// are added, and the rotation is that of both. Scale factors are taken to be right: 10 ppm are 1.5e-4 °/h.
///
/// Fails with usage if a size does not fit, a number is not finite, a standard deviation is below 0, the latitude is
/// beyond ± 90° or to_local is no rotation; with numeric if it does not converge.
[[nodiscard]] Result<RestEstimate> at_rest(const Geometry& geometry,
                                           const Eigen::Ref<const Eigen::VectorXd>& readings_deg_per_h,
                                           const Attitude& attitude, const BiasPrior& prior);

/// The same as a test for faults, of three axes too: the vector is W (y − H to_localᵀ Ω − b₀), W whitening the
/// covariance of that, C + B + J P Jᵀ, to the first order in the angles; each axis is a candidate.
struct RestTest {
  Eigen::MatrixXd whitening;           ///< W
  Eigen::VectorXd expected_deg_per_h;  ///< what is subtracted from the readings
  FaultTest test;
};
/// Fails as at_rest() does.
[[nodiscard]] Result<RestTest> rest_test(const Geometry& geometry, const Attitude& attitude, const BiasPrior& prior);

/// The heading of a fixture that is level and at rest, and its uncertainty.
struct North {
  double heading_deg{};   ///< of the fixture's first axis, from north over east, above −180° and at most 180°
  double standard_deg{};  ///< u
  double expanded_deg{};  ///< U, 95 %, k = 1.96
};

/// Standard uncertainties of the tilt of a fixture that should be level.
struct Tilt {
  double about_north_deg{}, about_east_deg{};
};

/// Finds north from the Earth's rotation: the heading is atan2(−ω₂, ω₁). Of the horizontal part of the Earth's
/// rotation, Ω cos φ, a fixture that heads by ψ sees Ω cos φ cos ψ on its first axis and −Ω cos φ sin ψ on its second.
/// To the first order its error is that of the rate towards east over Ω cos φ, and a tilt about north times tan φ
/// (Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed. 2004, chapter 10, on gyrocompass
/// alignment): u² = (eᵀ Σ e)/(Ω cos φ)² + (u_tilt tan φ)², u_tilt about north, e the direction of east in the fixture
/// and Σ the covariance of the rate.
///
/// The rate is one at rest, its covariance with the uncertainty of the biases in it; the fixture's third axis points
/// down but for the tilt. Fails with usage if the latitude is beyond ± 90° or an uncertainty of the tilt not 0 or more;
/// with numeric if the horizontal rate is not ten times as large as its uncertainty towards east, as near a pole, since
/// the first order is then not enough, or if it differs from Ω cos φ by more than ten times its own uncertainty and
/// what the tilt does to it: then the fixture is not at rest, or not at that latitude.
[[nodiscard]] Result<North> north_of(const FusedRate& rate, double latitude_deg, const Tilt& tilt);

}  // namespace gyrotherm::fusion
