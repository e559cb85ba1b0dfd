// SPDX-License-Identifier: Apache-2.0
/// The limit of a cumulative sum whose vectors are not quite white, from a record in which nothing is at fault.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace gyrotherm::fusion {

inline constexpr Eigen::Index kBlock = 36;           ///< steps: an hour of 100 s
inline constexpr Eigen::Index kFewestHealthy = 360;  ///< vectors, ten blocks

/// Returns the limit at which the sum of ChangeDetector has this average run length over vectors like the healthy ones,
/// a column each in the order of time, all finite. A model's error lasts for up to half an hour, in which small means
/// add up: this, and not the variance of single vectors, is what makes alarms more frequent than those of white ones.
///
/// The run length is that of blocks of an hour drawn from the record with a fixed seed (circular block bootstrap,
/// Politis and Romano, 1992). A record cannot show runs that are longer than itself. Beyond its own length the limit is
/// that of white vectors with the one standard deviation s that explains the limit found at its own length: s h(k/s), h
/// the limit of run_length.hpp.
///
/// It is never below the limit of white vectors. Returns nothing for fewer than 360 vectors. `slack` and `run_length`
/// as limit_for_run_length() takes them.
[[nodiscard]] std::optional<double> limit_of_healthy(const Eigen::Ref<const Eigen::MatrixXd>& healthy, double slack,
                                                     double run_length);

}  // namespace gyrotherm::fusion
