#include "analysis/correlation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace gyrotherm {
namespace {

std::string statement_of(const Selection& selection, std::size_t pairs, std::size_t passed) {
  std::vector<std::string> names;
  for (const Term& term : selection.terms) names.push_back(text(term));
  if (!selection.fallback) {
    return fmt::format("{} of {} gradients have |r| > {}: {} (rank {})", passed, pairs, selection.threshold,
                       fmt::join(names, ", "), selection.rank);
  }
  return fmt::format(
      "{} of {} gradients have |r| > {}, too few to choose from; the differences with {} are used: {} (rank {})",
      passed, pairs, selection.threshold, selection.terms.front().first, fmt::join(names, ", "), selection.rank);
}

}  // namespace

double pearson(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b) {
  assert(a.size() == b.size());
  const Eigen::VectorXd da = a.array() - a.mean();
  const Eigen::VectorXd db = b.array() - b.mean();
  const double norms = da.norm() * db.norm();
  return norms > 0 ? std::clamp(da.dot(db) / norms, -1.0, 1.0) : 0.0;
}

Correlation correlate(const Clusters& clusters, const std::vector<std::string>& names) {
  const auto count = static_cast<Eigen::Index>(names.size());
  const Eigen::VectorXd& bias = clusters.bias_deg_per_h;
  Correlation r;
  r.names = names;
  r.gradient.setZero(count, count);
  r.temperature.resize(count);
  r.rate.resize(count);
  std::vector<Eigen::Index> column;
  for (const std::string& name : names) {
    const auto at = std::ranges::find(clusters.thermometers, name);
    assert(at != clusters.thermometers.end());
    column.push_back(at - clusters.thermometers.begin());
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    r.temperature(i) = pearson(clusters.temperature_c.col(column[i]), bias);
    r.rate(i) = pearson(clusters.rate_c_per_min.col(column[i]), bias);
    for (Eigen::Index j = i + 1; j < count; ++j) {
      r.gradient(i, j) = pearson(clusters.temperature_c.col(column[i]) - clusters.temperature_c.col(column[j]), bias);
      r.gradient(j, i) = -r.gradient(i, j);
    }
  }
  return r;
}

Selection select_pairs(const std::vector<std::string>& names, const Eigen::MatrixXd& r, double threshold,
                       int least_rank) {
  assert(names.size() >= 2 && r.rows() == static_cast<Eigen::Index>(names.size()) && r.cols() == r.rows());
  Selection selection;
  selection.threshold = threshold;
  for (Eigen::Index i = 0; i < r.rows(); ++i) {
    for (Eigen::Index j = i + 1; j < r.cols(); ++j) {
      if (std::abs(r(i, j)) > threshold) selection.terms.push_back({TermKind::gradient, names[i], names[j]});
    }
  }
  const std::size_t passed = selection.terms.size();
  selection.rank = rank_of(selection.terms);
  if (selection.rank < least_rank) {
    selection.fallback = true;
    selection.terms.clear();
    for (std::size_t j = 1; j < names.size(); ++j) selection.terms.push_back({TermKind::gradient, names[0], names[j]});
    selection.rank = rank_of(selection.terms);
  }
  selection.statement = statement_of(selection, names.size() * (names.size() - 1) / 2, passed);
  return selection;
}

}  // namespace gyrotherm
