// SPDX-License-Identifier: Apache-2.0
/// Chooses C, σ and ε of an ε-SVR by particle swarm in log2 space; the fitness is the mean squared error on held-out
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

/// One held-out fold, ready to train: selection and scaling were fitted on its training part alone.
/// Targets are in units of the fold's own training STD; `target_scale` turns an error of them into °/h.
struct TuningFold {
  SampleMatrix train_x;
  Eigen::VectorXd train_y;
  SampleMatrix test_x;
  Eigen::VectorXd test_y;
  double target_scale{};
  /// Which rows of what was split into folds are trained on, so that one fold's training begins where another's ended;
  /// empty: not known.
  std::vector<Eigen::Index> train_rows = {};
};

/// Checks one fold. Fails with usage: a fold without rows on both sides or with shapes that differ, a value that is not
/// finite. `number` names the fold.
[[nodiscard]] Result<void> check_fold(const TuningFold& fold, std::size_t number);
/// Checks all folds. Fails with usage as check_fold does for the first that it finds wrong, or if there is no fold.
template <std::derived_from<TuningFold> Fold>
[[nodiscard]] Result<void> check_folds(std::span<const Fold> folds) {
  if (folds.empty()) return failure(FaultKind::usage, "tuning", "no fold");
  for (std::size_t f = 0; f < folds.size(); ++f)
    if (auto sound = check_fold(folds[f], f); !sound) return sound;
  return {};
}

/// The box of errata 4, in log2, and how it is searched.
struct TuningOptions {
  std::pair<double, double> log2_c{-2, 12}, log2_sigma{-2, 3.5}, log2_epsilon{-8, -1};  ///< lower and upper bounds
  double fixed_epsilon = 0;  ///< > 0: the paper's two-dimensional search over C and σ at this ε
  /// one_standard_error judges every position on every fold: the swarm takes the same way, and more time.
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

/// What the tuning found, and how sure it is.
struct TuningSummary {
  SvrParameters best;  ///< by the rule
  /// Its (°/h)², over all held-out rows, by trainings that begin at no other position's solution: what
  /// cross_validation_error says. The swarm's own figure may differ from it as the certificate allows.
  double cross_validation_mse{};
  int uncertified{};  ///< positions with a training that missed its certificate: never a best one
  SwarmSummary swarm;
  std::vector<std::string> warnings;                          ///< "log2 C = 12 lies on the edge of its box", …
  std::optional<OneStandardErrorSummary> one_standard_error;  ///< where that rule chose
};

/// The mean squared error over all held-out rows, in the units of target_scale squared. Stops after the fold in which
/// it passes `limit`, and returns what it has then: the sum can only grow. Fails as check_folds and solve_svr do.
[[nodiscard]] Result<double> cross_validation_error(std::span<const TuningFold> folds, const SvrParameters& parameters,
                                                    const SvrOptions& options, double limit);

/// Tunes by particle swarm. A position where a training misses its certificate counts as infinitely bad, and is counted
/// and warned of. Fails with usage, with interrupted, or with numeric if no position at all could be certified.
[[nodiscard]] Result<TuningSummary> tune_svr(std::span<const TuningFold> folds, const TuningOptions& options,
                                             const ProgressSink& progress = {});

}  // namespace gyrotherm::svm
