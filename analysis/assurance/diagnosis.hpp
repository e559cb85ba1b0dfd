// SPDX-License-Identifier: Apache-2.0
/// Diagnosis of a change between check runs: a thermometer, the mount, the golden gyro, or a false alarm. Each
/// hypothesis predicts a pattern of changes; the changes of all results are compared with the patterns at once.
///
/// y is the difference between the mean results since the change and before it, with the covariance C. A hypothesis has
/// patterns S with amplitudes of the covariance A, so that y ~ N(0, C + S A Sᵀ). Its posterior probability follows from
/// this density and its prior; its fit from the χ² of the residual y − S â of the generalised least squares estimate â.
/// For the fit, C also contains the certified drift of the thermometers in the time between: thermometers may drift
/// while the mount is tilted.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "analysis/assurance/history.hpp"

namespace gyrotherm::assurance {

enum class ChangeCause { thermometer, mount, gyro, false_alarm };
[[nodiscard]] const char* name(ChangeCause cause);

/// Posterior probability from which a cause is named, and probability of its χ² below which it is not.
inline constexpr double kNamed = 0.9, kFits = 1e-3;

struct Hypothesis {
  ChangeCause cause{};
  /// The thermometer, or the axis and the kind of change ("x, with temperature"); empty for the mount.
  std::string part{};
  double posterior{};
  double chi_squared{};  ///< the residual's chi-squared
  double degrees{};
  double fits{};  ///< probability of a χ² at least as large
  /// Estimate of the first amplitude with its standard uncertainty: K for a thermometer, ° of tilt for the mount, °/h
  /// for the gyro. Unknown for a false alarm. The tilt of a mount is its size within the plane that the axes can see.
  double amount{}, amount_u{};
  std::string unit{};
};

struct Diagnosis {
  std::size_t since{};            ///< index of the first run after the change
  std::size_t before{}, after{};  ///< numbers of runs that are compared
  /// All hypotheses, the most probable first.
  std::vector<Hypothesis> hypotheses{};
  /// Posterior probability of each cause, in the order of the enumerator.
  double probabilities[4]{};
  /// The cause, if its probability is at least kNamed and its best hypothesis fits.
  std::optional<ChangeCause> named{};
  /// Mount or gyro is probable, and there is one axis in one position: a tilt of the mount and a constant drift of the
  /// gyro have the same pattern.
  bool tilt_equals_drift{};
};

/// Diagnoses the last run of the history. Empty if there are fewer than four runs before any change, or if results are
/// missing. The run of the change is the one among the last 15 that maximises χ² of y; explained runs are not compared.
[[nodiscard]] std::optional<Diagnosis> diagnose(const History& history, const Assessment& assessment);

}  // namespace gyrotherm::assurance
