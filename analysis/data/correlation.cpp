#include "analysis/data/correlation.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace gyrotherm {
namespace {

/// Clusters with a rate: not the first of a run, nor the first after a gap.
std::vector<Eigen::Index> rows_with_rate(const Clusters& clusters) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < clusters.rate_c_per_min.rows(); ++k) {
    if (clusters.rate_c_per_min.row(k).allFinite()) rows.push_back(k);
  }
  return rows;
}

}  // namespace

double pearson(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b) {
  assert(a.size() == b.size());
  if (a.size() == 0) return 0;
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
  const std::vector<Eigen::Index> with_rate = rows_with_rate(clusters);
  const Eigen::VectorXd bias_with_rate = bias(with_rate);
  std::vector<Eigen::Index> column;
  for (const std::string& name : names) {
    const auto at = std::ranges::find(clusters.thermometers, name);
    assert(at != clusters.thermometers.end());
    column.push_back(at - clusters.thermometers.begin());
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    r.temperature(i) = pearson(clusters.temperature_c.col(column[i]), bias);
    r.rate(i) = pearson(clusters.rate_c_per_min.col(column[i])(with_rate), bias_with_rate);
    for (Eigen::Index j = i + 1; j < count; ++j) {
      r.gradient(i, j) = pearson(clusters.temperature_c.col(column[i]) - clusters.temperature_c.col(column[j]), bias);
      r.gradient(j, i) = -r.gradient(i, j);
    }
  }
  return r;
}

}  // namespace gyrotherm
