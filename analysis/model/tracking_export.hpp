// SPDX-License-Identifier: Apache-2.0
/// Bias tracking as C, beside an exported model.
#pragma once

#include <string>
#include <string_view>

#include "analysis/tracking/bias_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

/// What an exported program has of it.
struct TrackingInC {
  std::string declarations;  ///< for the header: NAME_tracker, NAME_track_start, NAME_track
  std::string definitions;   ///< for the source; needs <math.h>
  std::string test;          ///< for the body of NAME_self_test: returns 1 if known answers do not come out again
};

/// RestTracker in C, its constants those of the noise at means over `seconds`: a whole Kalman filter of four states
/// without allocation, some hundred operations once in so many seconds. Its covariance goes along instead of a gain
/// that is fixed, since it is the start that matters most: while a turn-on is being learnt the gain falls from near 1
/// to a hundredth, and it rises again after the gyro has moved for hours.
/// Fails with usage if a constant or a known answer is not finite.
[[nodiscard]] Result<TrackingInC> tracking_in_c(const tracking::BiasNoise& noise, int seconds, std::string_view name);

}  // namespace gyrotherm::model
