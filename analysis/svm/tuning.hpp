// SPDX-License-Identifier: Apache-2.0
/// Choice of C, σ and ε of an ε-SVR by particle swarm in log2 space. The fitness is the mean squared error on held-out
/// folds.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis/svm/choice_rule.hpp"
#include "analysis/svm/svr.hpp"
#include "analysis/svm/swarm.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::svm {

/// One held-out fold, ready to train. Selection and scaling were fitted to its training rows only. Targets are in units
/// of the training STD of the fold; `target_scale` converts errors in these units to °/h.
struct TuningFold {
  SampleMatrix train_x;
  Eigen::VectorXd train_y;
  SampleMatrix test_x;
  Eigen::VectorXd test_y;
  double target_scale{};
  /// Row numbers of the training rows in the data set that was split. With them, the training of one fold can start
  /// from the solution of another fold. Empty if unknown.
  std::vector<Eigen::Index> train_rows = {};
};

/// Checks one fold. Fails with usage if one side is empty, if shapes differ, or if a value is not finite. `number`
/// identifies the fold in messages.
[[nodiscard]] Result<void> check_fold(const TuningFold& fold, std::size_t number);
/// Checks all folds. Fails with usage if check_fold fails for a fold, or if there are no folds.
template <std::derived_from<TuningFold> Fold>
[[nodiscard]] Result<void> check_folds(std::span<const Fold> folds) {
  if (folds.empty()) return failure(FaultKind::usage, "tuning", "no fold");
  for (std::size_t f = 0; f < folds.size(); ++f)
    if (auto sound = check_fold(folds[f], f); !sound) return sound;
  return {};
}

/// Search box of errata 4, in log2, and search options.
struct TuningOptions {
  /// Lower and upper bounds.
  std::pair<double, double> log2_c{-2, 12}, log2_sigma{-2, 3.5}, log2_epsilon{-8, -1};
  /// Fixed ε if > 0; must be finite. Only C and σ are then searched, as in the paper.
  double fixed_epsilon = 0;
  /// Rule of choice. one_standard_error evaluates every position on every fold, which takes more time but does not
  /// change the path of the swarm.
  ChoiceRule choice = ChoiceRule::best;
  SwarmOptions swarm;
  SvrOptions svr;
};

void describe_bounds(auto& form, Like<TuningOptions> auto& options) {
  form("log2_c", options.log2_c);
  form("log2_sigma", options.log2_sigma);
  form("log2_epsilon", options.log2_epsilon);
  form("fixed_epsilon", not_negative(options.fixed_epsilon));
}

void describe(auto& form, Like<TuningOptions> auto& options) {
  describe_bounds(form, options);
  form("relative_gap", options.svr.relative_gap);
  form("max_newton_steps", options.svr.max_newton_steps);
  form("swarm", options.swarm);
}

/// Result of a tuning, with its uncertainty.
struct TuningSummary {
  /// Parameters chosen by the rule.
  SvrParameters best;
  /// Mean squared error of `best` in (°/h)² over all held-out rows, as returned by cross_validation_error, which starts
  /// no training from the solution of another position. The value found by the swarm may differ from it within the
  /// accuracy of the certificate.
  double cross_validation_mse{};
  /// Number of positions with a training that missed its certificate. Such a position never becomes the best.
  int uncertified{};
  SwarmSummary swarm;
  /// "log2 C = 12 is at a bound of its search range", …
  std::vector<std::string> warnings;
  /// Set if the one-standard-error rule was applied.
  std::optional<OneStandardErrorSummary> one_standard_error;
};

/// Computes the mean squared error over all held-out rows, in units of target_scale squared. Stops after the fold in
/// which the sum exceeds `limit` and returns that partial sum, because further folds can only increase it. Fails as
/// check_folds and solve_svr do.
[[nodiscard]] Result<double> cross_validation_error(std::span<const TuningFold> folds, const SvrParameters& parameters,
                                                    const SvrOptions& options, double limit);

/// Tunes by particle swarm. A position with a training that misses its certificate gets an infinite error; a warning
/// reports the number of such positions. Fails with usage, with interrupted, or with numeric if no position could be
/// certified.
[[nodiscard]] Result<TuningSummary> tune_svr(std::span<const TuningFold> folds, const TuningOptions& options,
                                             const ProgressSink& progress = {});

}  // namespace gyrotherm::svm
