// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/recommendation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <tuple>

namespace gyrotherm::model {
namespace {

constexpr double kCoverageFactor = 2;

double mean_value(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Returns the standard deviation of the values divided by the square root of their number; 0 for a single value.
double error_of_mean(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double mean = mean_value(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  const auto count = static_cast<double>(values.size());
  return std::sqrt(sum / (count - 1) / count);
}

CandidateResult compare_to_lowest(const Candidate& lowest, const Candidate& candidate) {
  std::vector<double> behind;
  for (std::size_t r = 0; r < candidate.held_out_mse.size(); ++r)
    behind.push_back(candidate.held_out_mse[r] - lowest.held_out_mse[r]);
  const double rmse = std::sqrt(mean_value(candidate.held_out_mse));
  CandidateResult result{.name = candidate.name,
                         .stored_numbers = candidate.stored_numbers,
                         .rmse_deg_per_h = rmse,
                         .expanded_deg_per_h = kCoverageFactor * rmse,
                         .behind_mse = mean_value(behind),
                         .behind_error_mse = error_of_mean(behind)};
  result.within = result.behind_mse <= result.behind_error_mse;
  return result;
}

/// Formats the statement. `not_compared` are the names of candidates without a finite error.
std::string make_statement(const Recommendation& found, int within, const std::vector<std::string>& not_compared) {
  return fmt::format(
      "the fewest stored parameters among {} of {} models within one standard error of the lowest expanded uncertainty "
      "({}), on {} record{} of profiles that {} not used for training; the random run was not used for the choice{}",
      within, found.candidates.size(), found.lowest, found.records, found.records == 1 ? "" : "s",
      found.records == 1 ? "was" : "were",
      not_compared.empty() ? ""
                           : fmt::format("; not compared, because they cannot be trained on these records: {}",
                                         fmt::join(not_compared, ", ")));
}

}  // namespace

Recommendation recommend(const std::vector<Candidate>& candidates) {
  Recommendation found;
  found.statement = "none: no independent record for the choice; supply one with --further";
  std::vector<Candidate> finite;
  std::vector<std::string> not_compared;
  for (const Candidate& candidate : candidates) {
    assert(candidate.held_out_mse.size() == candidates.front().held_out_mse.size());
    const bool known = !candidate.held_out_mse.empty() && std::isfinite(mean_value(candidate.held_out_mse));
    known ? finite.push_back(candidate) : not_compared.push_back(candidate.name);
  }
  if (finite.empty()) {
    if (!candidates.empty() && !candidates.front().held_out_mse.empty())
      found.statement = "none: no model can be both trained and compared on the further records";
    return found;
  }
  const auto by_error = [](const Candidate& c) { return std::tuple(mean_value(c.held_out_mse), c.stored_numbers); };
  std::ranges::stable_sort(finite, {}, by_error);
  found.lowest = finite.front().name;
  found.records = static_cast<int>(finite.front().held_out_mse.size());
  for (const Candidate& candidate : finite) found.candidates.push_back(compare_to_lowest(finite.front(), candidate));
  const CandidateResult* simplest = &found.candidates.front();
  for (const CandidateResult& result : found.candidates) {
    if (result.within && result.stored_numbers < simplest->stored_numbers) simplest = &result;
  }
  found.recommended = simplest->name;
  const auto within = std::ranges::count(found.candidates, true, &CandidateResult::within);
  found.statement = make_statement(found, static_cast<int>(within), not_compared);
  return found;
}

}  // namespace gyrotherm::model
