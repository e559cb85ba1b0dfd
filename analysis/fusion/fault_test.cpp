// SPDX-License-Identifier: Apache-2.0
#include "analysis/fusion/fault_test.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "analysis/data/distributions.hpp"

namespace gyrotherm::fusion {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

double chi_squared_limit_for(int freedom, double false_alarm_probability) {
  return freedom < 1 ? kInfinite : data::chi_squared_limit(false_alarm_probability, freedom);
}

/// Returns true if the candidate has an effect on the vector. An effect that is much smaller than the greatest one is
/// regarded as a rounding error.
bool has_effect(const FaultTest& test, Eigen::Index candidate) {
  constexpr double kRounding = 1e-9;
  const double norm = test.effects.col(candidate).norm();
  return norm > 0 && norm > kRounding * test.effects.colwise().norm().maxCoeff();
}

/// Returns the part of the statistic that each candidate's fault explains; NaN for a candidate without an effect.
Eigen::VectorXd explained_statistics(const FaultTest& test, const Eigen::VectorXd& vector) {
  Eigen::VectorXd explained(test.effects.cols());
  for (Eigen::Index i = 0; i < explained.size(); ++i) {
    const double along = test.effects.col(i).dot(vector);
    explained(i) = has_effect(test, i) ? along * along / test.effects.col(i).squaredNorm()
                                       : std::numeric_limits<double>::quiet_NaN();
  }
  return explained;
}

}  // namespace

std::optional<Isolation> isolate(const FaultTest& test, const Eigen::Ref<const Eigen::VectorXd>& vector,
                                 const TestOptions& options) {
  const Eigen::VectorXd explained = explained_statistics(test, vector);
  std::optional<Isolation> found;
  for (Eigen::Index i = 0; i < explained.size(); ++i) {
    if (std::isnan(explained(i)) || (found && explained(i) <= explained(found->likeliest))) continue;
    found = Isolation{.likeliest = i};
  }
  if (!found) return found;
  const Eigen::Index best = found->likeliest;
  found->margin = kInfinite;
  for (Eigen::Index i = 0; i < explained.size(); ++i) {
    if (i == best || std::isnan(explained(i))) continue;
    const double behind = explained(best) - explained(i);
    found->margin = std::min(found->margin, behind);
    if (behind < options.margin) found->rivals.push_back(i);
  }
  const double square = test.effects.col(best).squaredNorm();
  found->size = test.effects.col(best).dot(vector) / square;
  found->size_std = 1 / std::sqrt(square);
  found->left = std::max(0.0, vector.squaredNorm() - explained(best));
  found->explains =
      found->left <= chi_squared_limit_for(test.degrees_of_freedom() - 1, options.false_alarm_probability);
  if (found->explains && found->rivals.empty()) found->candidate = best;
  return found;
}

Finding examine(const FaultTest& test, const Eigen::Ref<const Eigen::VectorXd>& vector, const TestOptions& options) {
  assert(vector.size() == test.effects.rows() && vector.allFinite());
  Finding finding{.statistic = vector.squaredNorm(),
                  .limit = chi_squared_limit_for(test.degrees_of_freedom(), options.false_alarm_probability),
                  .freedom = test.degrees_of_freedom()};
  finding.fault = finding.statistic > finding.limit;
  if (finding.fault) finding.isolation = isolate(test, vector, options);
  return finding;
}

double detection_probability(const FaultTest& test, Eigen::Index candidate, double size,
                             double false_alarm_probability) {
  if (test.degrees_of_freedom() < 1) return 0;
  const double shift = size * test.effects.col(candidate).norm();
  return data::noncentral_chi_squared_exceeds(chi_squared_limit_for(test.degrees_of_freedom(), false_alarm_probability),
                                              test.degrees_of_freedom(), shift * shift);
}

double detectable_size(const FaultTest& test, Eigen::Index candidate, double probability,
                       double false_alarm_probability) {
  assert(probability > false_alarm_probability && probability < 1);
  if (test.degrees_of_freedom() < 1 || !has_effect(test, candidate)) return kInfinite;
  const auto detected = [&](double size) {
    return detection_probability(test, candidate, size, false_alarm_probability);
  };
  double low = 0, high = 1 / test.effects.col(candidate).norm();
  while (detected(high) < probability) high *= 2;
  constexpr int kHalvings = 50;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (detected(middle) < probability ? low : high) = middle;
  }
  return high;
}

}  // namespace gyrotherm::fusion
