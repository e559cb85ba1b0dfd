// SPDX-License-Identifier: Apache-2.0
/// North from the Earth's rotation: the heading of a fixture that is level and at rest, and how uncertain it is.
#pragma once

#include "analysis/fusion/rate_fusion.hpp"

namespace gyrotherm::fusion {

struct North {
  double heading_deg{};   ///< of the fixture's first axis, from north over east, above −180° and at most 180°
  double standard_deg{};  ///< u
  double expanded_deg{};  ///< U, 95 %, k = 1.96
};

/// Standard uncertainties of the tilt of a fixture that should be level.
struct Tilt {
  double about_north_deg{}, about_east_deg{};
};

/// The heading is atan2(−ω₂, ω₁): of the horizontal part of the Earth's rotation, Ω cos φ, a fixture that heads by ψ
/// sees Ω cos φ cos ψ on its first axis and −Ω cos φ sin ψ on its second. To the first order its error is that of the
/// rate towards east over Ω cos φ, and a tilt about north times tan φ (Titterton and Weston, Strapdown Inertial
/// Navigation Technology, 2nd ed. 2004, chapter 10, on gyrocompass alignment): u² = (eᵀ Σ e)/(Ω cos φ)² + (u_tilt tan
/// φ)², u_tilt about north, e the direction of east in the fixture and Σ the covariance of the rate.
///
/// The rate is one at rest, its covariance with the uncertainty of the biases in it; the fixture's third axis points
/// down but for the tilt. Fails with usage if the latitude is beyond ± 90° or an uncertainty of the tilt not 0 or more;
/// with numeric if the horizontal rate is not ten times as large as its uncertainty towards east, as near a pole, since
/// the first order is then not enough, or if it differs from Ω cos φ by more than ten times its own uncertainty and
/// what the tilt does to it: then the fixture is not at rest, or not at that latitude.
[[nodiscard]] Result<North> north_of(const FusedRate& rate, double latitude_deg, const Tilt& tilt);

}  // namespace gyrotherm::fusion
