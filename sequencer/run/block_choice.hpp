// SPDX-License-Identifier: Apache-2.0
/// The decisions of a run that ends by itself: which released block comes next, or why the run ends. Pure: the same
/// inputs give the same decision.
#pragma once

#include <vector>

#include "acquisition/record/decision.hpp"
#include "core/quantity.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::run {

/// A decision is due when the last hold has at most this time left: two clusters.
inline constexpr Duration kDecisionTime = std::chrono::seconds(200);

/// A block lowers the uncertainty only if it lowers it by more than this fraction.
inline constexpr double kLeastGain = 0.005;

/// Blocks whose decrease per hour is at least this fraction of the greatest are equal.
inline constexpr double kEqualShare = 0.9;

/// The reasons for the end of a run.
inline constexpr const char *kMet = "U is met", *kCannotBeMet = "U cannot be met", *kTimeIsUp = "the time is up";

struct DecisionInputs {
  int number{};  ///< number of the decision, counted from 1
  double target_deg_per_h{};
  /// Expanded uncertainty on the mission; infinite if no model can be fitted yet.
  double u_now_deg_per_h{};
  /// The same, expected after each released block; infinite where a block is of no use.
  std::vector<double> u_after_deg_per_h{};
  /// Share of U that each block removes, for the choice; empty: from the uncertainties above. The noise of the record
  /// has no influence on it, so a resumed run chooses alike.
  std::vector<double> gains{};
  /// Duration of the run so far, and of the rest of its last hold.
  Duration used{};
  Duration hold_left{};
  /// The record is too short for a model, so the run continues with the first block that fits.
  bool is_record_short{};
};

/// Decides how a run continues at the end of its profile.
///
/// 1. The run ends if U, rounded to three significant digits, is at most the target.
/// 2. A block is useful if it fits into the remaining time with the closing segments and lowers U by more than
///    kLeastGain. The useful block with the greatest gain per hour is chosen, or the first one that is equal
///    to it (kEqualShare). While U is unknown, the block with the lowest U after it is chosen in the same way, or
///    the first block if the record is still too short for a model.
/// 3. Without such a block the run ends: the time is up if a block that does not fit would lower U, or if no block
///    fits; otherwise U cannot be met.
///
/// Equal blocks are chosen by their order, so a resumed run with slightly other noise decides alike. The decision
/// contains the uncertainties with three significant digits. The profile must be open. `u_after_deg_per_h` must have
/// one value per released block.
[[nodiscard]] record::Decision decide(const profile::Profile& profile, const DecisionInputs& inputs);

}  // namespace gyrotherm::run
