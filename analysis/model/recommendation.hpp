// SPDX-License-Identifier: Apache-2.0
/// Which model is recommended, by rule and not by name: the simplest of those whose expanded uncertainty on programs
/// that they have not seen is not distinguishable from the lowest.
#pragma once

#include <string>
#include <vector>

#include "core/form.hpp"

namespace gyrotherm::model {

/// A model as the rule sees it.
struct Candidate {
  std::string name;      ///< "multi_point_t", "linear-seven-point"
  int stored_numbers{};  ///< its size in a navigation computer: what "simple" means
  /// The mean squared error of each held-out record of another program than was learnt from, (°/h)², by a model whose
  /// parameters were chosen without it; and what is known to come to that in use.
  std::vector<double> held_out_mse;
};

/// What the rule found of one candidate.
struct JudgedCandidate {
  std::string name;
  int stored_numbers{};
  double rmse_deg_per_h{};      ///< over all held-out records, each counting alike
  double expanded_deg_per_h{};  ///< 2·rmse: k = 2
  double behind_mse{};          ///< its mean squared error less that of the lowest, (°/h)²
  double behind_error_mse{};    ///< the standard error of that difference, record by record; 0 of a single record
  bool within{};                ///< behind by at most one standard error
};

void describe(auto& form, Like<JudgedCandidate> auto& judged) {
  form("name", judged.name);
  form("stored_numbers", judged.stored_numbers);
  form("rmse_deg_per_h", judged.rmse_deg_per_h);
  form("expanded_uncertainty_deg_per_h", judged.expanded_deg_per_h);
  form("behind_mse", judged.behind_mse);
  form("behind_error_mse", judged.behind_error_mse);
  form("within_one_standard_error", judged.within);
}

struct Recommendation {
  std::string recommended;                  ///< empty: there was no record to choose on
  std::string lowest;                       ///< the candidate of lowest expanded uncertainty
  int records{};                            ///< held out
  std::string statement;                    ///< the rule and what it found, in words
  std::vector<JudgedCandidate> candidates;  ///< by rising expanded uncertainty
};

void describe(auto& form, Like<Recommendation> auto& recommendation) {
  form("recommended", recommendation.recommended);
  form("lowest", recommendation.lowest);
  form("records", recommendation.records);
  form("statement", recommendation.statement);
  form("candidates", recommendation.candidates);
}

/// Recommends among candidates that were all held out on the same records. The lowest has
/// the least mean squared error over the records, each counting alike. A candidate is within one standard error if the
/// mean of its differences from the lowest, record by record, is at most their standard error: what all records have in
/// common, such as a turn-on bias, then favours none. Of those within, the one that stores the fewest numbers is
/// recommended; of equals, the one of lower error. A candidate whose error is not finite is never recommended; the
/// statement names it. With no
/// candidate or no record nothing is, and the statement says so.
[[nodiscard]] Recommendation recommend(const std::vector<Candidate>& candidates);

}  // namespace gyrotherm::model
