// SPDX-License-Identifier: Apache-2.0
/// Which of many inputs to take, learnt from one training set alone.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/features.hpp"
#include "analysis/data/folds.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

enum class SelectionKind {
  correlation,  ///< |r| with the bias above a threshold: the paper's §4.3
  forward,      ///< one after the other, each the one that gains most on held-out folds
  redundancy,   ///< all that do not depend on the others
};

/// How to select, as the user says it in one word and perhaps a number.
struct SelectionRule {
  SelectionKind kind = SelectionKind::correlation;
  double threshold = 0.90;  ///< of |r|
  int most = 12;            ///< forward: inputs, at most
  double tolerance =
      1e-6;  ///< redundancy: an input of which less than this part of its STD is its own depends on others
};

/// Reads "correlation", "correlation:0.85", "forward", "forward:6", "redundancy", "redundancy:0.01". Fails with usage.
[[nodiscard]] Result<SelectionRule> parse_selection(std::string_view text);

struct Selection {
  std::vector<data::Term> terms;
  double threshold = 0.90;  ///< correlation only, else 0
  int rank{};
  bool fallback{};        ///< too few passed: those that do not depend on the ones before them are used
  std::string statement;  ///< in words, for the report
};

/// Selects from the candidates by the rule, beside the fixed terms that are taken anyway. Fails with usage if there is
/// no candidate, or if a term needs a thermometer that the clusters lack. All values are finite.
[[nodiscard]] Result<Selection> select_inputs(const SelectionRule& rule, const std::vector<data::Term>& fixed,
                                              const std::vector<data::Term>& candidates,
                                              const data::TrainingSet& training_set);

/// The rule correlation, given each candidate's r, takes those with |r| > threshold. Where they span fewer dimensions
/// than `least_rank`, the candidates that do not depend on the ones before them are taken instead, and the selection
/// says so; of all 28 gradients these are the differences with the first thermometer (errata 3.1).
[[nodiscard]] Selection select_by_correlation(const std::vector<data::Term>& candidates, const std::vector<double>& r,
                                              double threshold, int least_rank);

/// The rule forward grows by the candidate whose response surface (response_surface.hpp) has the least held-out squared
/// error, while that error falls and fewer than `most` are taken; then keeps the fewest whose mean squared error is
/// within one standard error of the least (Breiman et al., Classification and Regression Trees, 1984, §3.4.3), reckoned
/// with the effective number of the squared residuals. A training set of fewer than two folds is cut into blocks.
[[nodiscard]] Result<Selection> select_forward(const std::vector<data::Term>& fixed,
                                               const std::vector<data::Term>& candidates,
                                               const data::TrainingSet& training_set, int most);

/// The rule redundancy is a QR with column pivoting of the standardised candidates, after the fixed terms have been
/// projected out. Candidates are kept while more than `tolerance` of their STD is their own; what remains is a
/// combination of those and the fixed to that part.
[[nodiscard]] Result<Selection> select_independent(const std::vector<data::Term>& fixed,
                                                   const std::vector<data::Term>& candidates,
                                                   const data::Clusters& training, double tolerance);

}  // namespace gyrotherm::model
