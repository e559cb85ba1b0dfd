#include "analysis/model/selection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>

#include "analysis/data/correlation.hpp"
#include "analysis/data/features.hpp"

namespace gyrotherm {
namespace {

std::string names_of(const std::vector<Term>& terms) {
  std::vector<std::string> names;
  for (const Term& term : terms) names.push_back(text(term));
  return fmt::format("{}", fmt::join(names, ", "));
}

bool all_gradients_of(const std::vector<Term>& terms) {
  return std::ranges::all_of(terms, [](const Term& term) {
    return term.factors.size() == 1 && term.factors.front().kind == FactorKind::gradient;
  });
}

std::string statement_of(const Selection& selection, const std::vector<Term>& candidates, std::size_t passed) {
  const std::string of = fmt::format("{} of {} {} have |r| > {}", passed, candidates.size(),
                                     all_gradients_of(candidates) ? "gradients" : "inputs", selection.threshold);
  const std::string what = fmt::format("{} (rank {})", names_of(selection.terms), selection.rank);
  if (!selection.fallback) return of + ": " + what;
  return of + ", too few to choose from; those independent of the ones before are used: " + what;
}

/// Each one that does not depend on those before it, whatever the temperatures are.
std::vector<Term> independent_of_those_before(const std::vector<Term>& candidates) {
  std::vector<Term> taken;
  for (const Term& term : candidates) {
    taken.push_back(term);
    if (rank_of(taken) < static_cast<int>(taken.size())) taken.pop_back();
  }
  return taken;
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc{} && read.ptr == text.data() + text.size();
}

}  // namespace

Result<SelectionRule> parse_selection(std::string_view text) {
  const auto colon = text.find(':');
  const auto word = text.substr(0, colon);
  const bool numbered = colon != text.npos;
  const auto number = numbered ? text.substr(colon + 1) : std::string_view{};
  SelectionRule rule;
  if (word == "correlation") {
    rule.kind = SelectionKind::correlation;
    if (!numbered || (read_number(number, rule.threshold) && rule.threshold >= 0 && rule.threshold <= 1)) return rule;
  } else if (word == "forward") {
    rule.kind = SelectionKind::forward;
    if (!numbered || (read_number(number, rule.most) && rule.most >= 1)) return rule;
  } else if (word == "redundancy") {
    rule.kind = SelectionKind::redundancy;
    if (!numbered || (read_number(number, rule.tolerance) && rule.tolerance > 0 && rule.tolerance < 1)) return rule;
  }
  return failure(FaultKind::usage, "--select",
                 fmt::format("\"{}\" is none of correlation[:R] with R from 0 to 1, forward[:N] with N at least 1, "
                             "redundancy[:PART] with PART between 0 and 1",
                             text));
}

Selection select_by_correlation(const std::vector<Term>& candidates, const std::vector<double>& r, double threshold,
                                int least_rank) {
  assert(candidates.size() == r.size());
  Selection selection;
  selection.threshold = threshold;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (std::abs(r[i]) > threshold) selection.terms.push_back(candidates[i]);
  }
  const std::size_t passed = selection.terms.size();
  selection.rank = rank_of(selection.terms);
  if (selection.rank < least_rank) {
    selection.fallback = true;
    selection.terms = independent_of_those_before(candidates);
    selection.rank = rank_of(selection.terms);
  }
  selection.statement = statement_of(selection, candidates, passed);
  return selection;
}

Result<Selection> select_inputs(const SelectionRule& rule, const std::vector<Term>& fixed,
                                const std::vector<Term>& candidates, const TrainingSet& training_set) {
  if (candidates.empty()) return failure(FaultKind::usage, "selection", "there is nothing to select from");
  switch (rule.kind) {
    case SelectionKind::forward: return select_forward(fixed, candidates, training_set, rule.most);
    case SelectionKind::redundancy: return select_independent(fixed, candidates, training_set.clusters, rule.tolerance);
    case SelectionKind::correlation: break;
  }
  const auto inputs = evaluate(candidates, training_set.clusters);
  if (!inputs) return failure(inputs.error());
  std::vector<double> r;
  for (Eigen::Index j = 0; j < inputs->cols(); ++j)
    r.push_back(pearson(inputs->col(j), training_set.clusters.bias_deg_per_h));
  constexpr int kLeastRank = 2;  // one gradient is no choice
  return select_by_correlation(candidates, r, rule.threshold, std::min(kLeastRank, rank_of(candidates)));
}

}  // namespace gyrotherm
