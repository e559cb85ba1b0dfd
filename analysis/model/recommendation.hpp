// SPDX-License-Identifier: Apache-2.0
/// Recommendation of a model by rule: the simplest model whose expanded uncertainty on unseen profiles cannot be
/// distinguished from the lowest.
#pragma once

#include <string>
#include <vector>

#include "core/form.hpp"

namespace gyrotherm::model {

/// A model as input of the rule.
struct Candidate {
  std::string name;  ///< "multi_point_t", "linear-seven-point"
  /// Number of parameters that a navigation computer stores; a model is simpler if it has fewer.
  int stored_numbers{};
  /// Mean squared error per held-out record, (°/h)², including known errors in use. Each record has a different profile
  /// from the training record, and the hyper-parameters were chosen without the record.
  std::vector<double> held_out_mse;
};

/// Result of the rule for one candidate.
struct CandidateResult {
  std::string name;
  int stored_numbers{};
  /// Root mean square over all held-out records, equally weighted.
  double rmse_deg_per_h{};
  double expanded_deg_per_h{};  ///< 2·rmse: k = 2
  /// Excess of the mean squared error over the lowest one of all candidates, (°/h)².
  double behind_mse{};
  /// Standard error of behind_mse, from the differences in each record; 0 for a single record.
  double behind_error_mse{};
  /// True if behind_mse is at most behind_error_mse, so the candidate may be recommended.
  bool within{};
};

void describe(auto& form, Like<CandidateResult> auto& result) {
  form("name", result.name);
  form("stored_numbers", result.stored_numbers);
  form("rmse_deg_per_h", result.rmse_deg_per_h);
  form("expanded_uncertainty_deg_per_h", result.expanded_deg_per_h);
  form("behind_mse", result.behind_mse);
  form("behind_error_mse", result.behind_error_mse);
  form("within_one_standard_error", result.within);
}

struct Recommendation {
  /// Name of the recommended model; empty if there was no record to compare the candidates on.
  std::string recommended;
  /// Candidate with the lowest expanded uncertainty.
  std::string lowest;
  int records{};  ///< held out
  /// The rule and its result, as text.
  std::string statement;
  /// Candidates in ascending order of expanded uncertainty.
  std::vector<CandidateResult> candidates;
};

void describe(auto& form, Like<Recommendation> auto& recommendation) {
  form("recommended", recommendation.recommended);
  form("lowest", recommendation.lowest);
  form("records", recommendation.records);
  form("statement", recommendation.statement);
  form("candidates", recommendation.candidates);
}

/// Recommends one of the candidates, which must all have the same held-out records. The lowest candidate has the least
/// mean squared error over the records, which are equally weighted. A candidate is within one standard error if the
/// mean of its differences from the lowest, by record, is at most their standard error; errors that all records share,
/// such as a turn-on bias, therefore cancel. Among the candidates within one standard error, the one with the fewest
/// stored parameters is recommended; if several have equally few, the one with the lowest error. A candidate with an
/// error that is not finite is never recommended; the statement lists it. Without a candidate or a record nothing is
/// recommended, and the statement gives the reason.
[[nodiscard]] Recommendation recommend(const std::vector<Candidate>& candidates);

}  // namespace gyrotherm::model
