// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/choice_rule.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <tuple>

namespace gyrotherm::svm {
namespace {

/// Returns a position in whole octaves. A lower value is simpler: log2 C keeps its sign, log2 σ and log2 ε are negated.
std::vector<double> complexity(const EvaluatedPosition& evaluated) {
  std::vector<double> octaves;
  for (std::size_t k = 0; k < evaluated.position.size(); ++k) {
    const double octave = std::floor(evaluated.position[k]);
    octaves.push_back(k == 0 ? octave : -octave);
  }
  return octaves;
}

}  // namespace

Result<ChoiceRule> parse_choice(std::string_view text) {
  if (text == "best") return ChoiceRule::best;
  if (text == "one-se") return ChoiceRule::one_standard_error;
  return failure(FaultKind::usage, "--choose", fmt::format("\"{}\" is neither best nor one-se", text));
}

double mean_squared_error(const EvaluatedPosition& evaluated) {
  double mean = 0;
  for (const double share : evaluated.shares) mean += share;
  return mean;
}

double standard_error(const EvaluatedPosition& evaluated, std::span<const double> parts) {
  assert(evaluated.shares.size() == parts.size());
  if (parts.size() < 2) return 0;
  const double mean = mean_squared_error(evaluated);
  double sum = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) sum += std::pow(evaluated.shares[k] - parts[k] * mean, 2);
  const auto folds = static_cast<double>(parts.size());
  return std::sqrt(folds / (folds - 1) * sum);
}

bool is_simpler(const EvaluatedPosition& a, const EvaluatedPosition& b) {
  const auto order = [](const EvaluatedPosition& evaluated) {
    return std::tuple(complexity(evaluated), mean_squared_error(evaluated), evaluated.position);
  };
  return order(a) < order(b);
}

OneStandardErrorChoice simplest_within_one_standard_error(std::span<const EvaluatedPosition> evaluated,
                                                          std::span<const double> parts) {
  assert(!evaluated.empty());
  OneStandardErrorChoice choice;
  for (std::size_t k = 1; k < evaluated.size(); ++k) {
    const double error = mean_squared_error(evaluated[k]), least = mean_squared_error(evaluated[choice.best]);
    if (error < least || (error == least && is_simpler(evaluated[k], evaluated[choice.best]))) choice.best = k;
  }
  choice.simplest = choice.best;
  choice.standard_error = standard_error(evaluated[choice.best], parts);
  const double limit = mean_squared_error(evaluated[choice.best]) + choice.standard_error;
  for (std::size_t k = 0; k < evaluated.size(); ++k) {
    if (mean_squared_error(evaluated[k]) > limit) continue;
    ++choice.within;
    if (is_simpler(evaluated[k], evaluated[choice.simplest])) choice.simplest = k;
  }
  return choice;
}

}  // namespace gyrotherm::svm
