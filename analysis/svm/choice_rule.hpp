// SPDX-License-Identifier: Apache-2.0
/// Which of the positions that a search has judged is taken: the one of least held-out error, as the paper does, or the
/// simplest that is not distinguishable from it.
///
/// A held-out error is a mean over folds and has a standard error of its own. Where the optimum is flat the position of
/// least error is drawn by the noise of the folds: over four gyros of one make C was 0.8 … 480 at equal error
/// (docs/evaluation.md). The one-standard-error rule takes the simplest position whose error is at most one standard
/// error above the least (Breiman et al. 1984, §3.4.3; Hastie, Tibshirani, Friedman 2009, §7.10).
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

/// Reads "best" or "one-se". Fails with usage.
[[nodiscard]] Result<ChoiceRule> parse_choice(std::string_view text);

/// A position of the search, log2 of C, σ and (unless it is fixed) ε, and what it was worth on every fold.
struct JudgedPosition {
  std::vector<double> position;
  std::vector<double> shares;  ///< of each fold in the mean squared error: Σ of its squares over all held-out rows
};

/// The mean squared error over all held-out rows: the sum of the shares.
[[nodiscard]] double mean_squared_error(const JudgedPosition& judged);

/// The standard error of that mean: with the part w_k of all rows that fold k holds out and its own mean squared error
/// e_k = share_k/w_k it is √(K/(K − 1) · Σ w_k²(e_k − ē)²), which for K equal folds is the standard deviation of the
/// e_k over √K. 0 of a single fold. Asserts one share for each part.
[[nodiscard]] double standard_error(const JudgedPosition& judged, std::span<const double> parts);

/// True if `a` is simpler than `b`: smaller C, then larger σ, then larger ε, each by whole octaves, since a search
/// never meets the same number twice; then of smaller error, then of smaller numbers.
[[nodiscard]] bool is_simpler(const JudgedPosition& a, const JudgedPosition& b);

/// What the one-standard-error rule found.
struct OneStandardErrorChoice {
  std::size_t best{};       ///< index of the position of least error
  std::size_t simplest{};   ///< index of the one that is taken
  double standard_error{};  ///< of the least error
  int within{};             ///< how many positions are within one standard error of the least, itself included
};

/// The rule over at least one position. Does not depend on their order.
[[nodiscard]] OneStandardErrorChoice simplest_within_one_standard_error(std::span<const JudgedPosition> judged,
                                                                        std::span<const double> parts);

/// How a choice by that rule is kept with a tuning; errors in (°/h)².
struct OneStandardErrorSummary {
  SvrParameters best;  ///< of least held-out error, which the rule passed over for a simpler one
  double best_mse{};
  double standard_error_mse{};  ///< of best_mse
  int within{};                 ///< positions within it
};

void describe(auto& form, Like<OneStandardErrorSummary> auto& summary) {
  form("best", summary.best);
  form("best_mse", summary.best_mse);
  form("standard_error_mse", summary.standard_error_mse);
  form("positions_within", summary.within);
}

}  // namespace gyrotherm::svm
