// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/choice_rule.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <tuple>

namespace gyrotherm::svm {
namespace {

/// Returns a position in whole octaves. A lower value is simpler: log2 C keeps its sign, log2 σ and log2 ε are negated.
std::vector<double> complexity(const JudgedPosition& judged) {
  std::vector<double> octaves;
  for (std::size_t k = 0; k < judged.position.size(); ++k) {
    const double octave = std::floor(judged.position[k]);
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

double mean_squared_error(const JudgedPosition& judged) {
  double mean = 0;
  for (const double share : judged.shares) mean += share;
  return mean;
}

double standard_error(const JudgedPosition& judged, std::span<const double> parts) {
  assert(judged.shares.size() == parts.size());
  if (parts.size() < 2) return 0;
  const double mean = mean_squared_error(judged);
  double sum = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) sum += std::pow(judged.shares[k] - parts[k] * mean, 2);
  const auto folds = static_cast<double>(parts.size());
  return std::sqrt(folds / (folds - 1) * sum);
}

bool is_simpler(const JudgedPosition& a, const JudgedPosition& b) {
  const auto order = [](const JudgedPosition& judged) {
    return std::tuple(complexity(judged), mean_squared_error(judged), judged.position);
  };
  return order(a) < order(b);
}

OneStandardErrorChoice simplest_within_one_standard_error(std::span<const JudgedPosition> judged,
                                                          std::span<const double> parts) {
  assert(!judged.empty());
  OneStandardErrorChoice choice;
  for (std::size_t k = 1; k < judged.size(); ++k) {
    const double error = mean_squared_error(judged[k]), least = mean_squared_error(judged[choice.best]);
    if (error < least || (error == least && is_simpler(judged[k], judged[choice.best]))) choice.best = k;
  }
  choice.simplest = choice.best;
  choice.standard_error = standard_error(judged[choice.best], parts);
  const double limit = mean_squared_error(judged[choice.best]) + choice.standard_error;
  for (std::size_t k = 0; k < judged.size(); ++k) {
    if (mean_squared_error(judged[k]) > limit) continue;
    ++choice.within;
    if (is_simpler(judged[k], judged[choice.simplest])) choice.simplest = k;
  }
  return choice;
}

}  // namespace gyrotherm::svm
