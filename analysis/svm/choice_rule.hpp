// SPDX-License-Identifier: Apache-2.0
/// Choice among the positions that a search has evaluated: either the position with the lowest held-out error, as in
/// the paper, or the simplest position that is not distinguishable from it.
///
/// A held-out error is a mean over folds and has its own standard error. Near a flat optimum, the noise of the folds
/// decides which position has the lowest error: for four gyros of one type, C varied from 0.8 to 480 at equal error
/// (docs/evaluation.md). The one-standard-error rule chooses the simplest position with an error at most one standard
/// error above the lowest (Breiman et al. 1984, §3.4.3; Hastie, Tibshirani, Friedman 2009, §7.10).
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/svm/svr.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::svm {

enum class ChoiceRule { best, one_standard_error };

/// Parses "best" or "one-se". Fails with usage.
[[nodiscard]] Result<ChoiceRule> parse_choice(std::string_view text);

/// Evaluated position of a search, in log2 of C, σ and (unless fixed) ε, with its error on every fold.
struct EvaluatedPosition {
  std::vector<double> position;
  /// Share of each fold in the mean squared error: its squared errors divided by the number of all held-out rows.
  std::vector<double> shares;
};

/// Returns the mean squared error over all held-out rows, the sum of the shares.
[[nodiscard]] double mean_squared_error(const EvaluatedPosition& evaluated);

/// Returns the standard error of mean_squared_error(). Let w_k be the fraction of all rows that fold k holds out, and
/// e_k = share_k/w_k the mean squared error of fold k. The result is √(K/(K − 1) · Σ w_k²(e_k − ē)²). For K equal folds
/// this is the standard deviation of the e_k over √K. Returns 0 for a single fold. `parts` contains w_k for each fold;
/// it must have as many elements as `evaluated` has shares.
[[nodiscard]] double standard_error(const EvaluatedPosition& evaluated, std::span<const double> parts);

/// Returns whether `a` is simpler than `b`: smaller C, then larger σ, then larger ε. C, σ and ε are compared in whole
/// octaves, since their exact values hardly ever coincide in a search. Among equally simple positions, the one with the
/// smaller error and then with the smaller coordinates counts as simpler.
[[nodiscard]] bool is_simpler(const EvaluatedPosition& a, const EvaluatedPosition& b);

/// Result of the one-standard-error rule.
struct OneStandardErrorChoice {
  /// Index of the position with the lowest error.
  std::size_t best{};
  /// Index of the chosen position.
  std::size_t simplest{};
  /// Standard error of the lowest error.
  double standard_error{};
  /// Number of positions with an error at most one standard error above the lowest, including the best position.
  int within{};
};

/// Applies the rule to at least one position. The result does not depend on their order.
[[nodiscard]] OneStandardErrorChoice simplest_within_one_standard_error(std::span<const EvaluatedPosition> evaluated,
                                                                        std::span<const double> parts);

/// Record of a choice by the one-standard-error rule, stored with a tuning. Errors are in (°/h)².
struct OneStandardErrorSummary {
  /// Position with the lowest held-out error. The rule may have chosen a simpler one instead.
  SvrParameters best;
  double best_mse{};
  /// Standard error of best_mse.
  double standard_error_mse{};
  /// Number of positions with an error at most one standard error above best_mse.
  int within{};
};

void describe(auto& form, Like<OneStandardErrorSummary> auto& summary) {
  form("best", summary.best);
  form("best_mse", summary.best_mse);
  form("standard_error_mse", summary.standard_error_mse);
  form("positions_within", summary.within);
}

}  // namespace gyrotherm::svm
