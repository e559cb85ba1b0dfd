// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace gyrotherm::data {

Eigen::VectorXi cluster_positions(const Clusters& clusters, const std::vector<Eigen::Index>& rows) {
  Eigen::VectorXi positions(static_cast<Eigen::Index>(rows.size()));
  int shift = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto position = static_cast<int>(std::lround(clusters.start_s(rows[i]) / clusters.length_s));
    const auto at = static_cast<Eigen::Index>(i);
    if (i > 0 && position + shift <= positions(at - 1))
      shift = positions(at - 1) + static_cast<int>(rows.size()) - position;
    positions(at) = position + shift;
  }
  return positions;
}

LaggedProduct lagged_product(const Eigen::Ref<const Eigen::VectorXd>& centred,
                             const Eigen::Ref<const Eigen::VectorXi>& positions, int lag) {
  assert(centred.size() == positions.size() && lag >= 0);
  double sum = 0;
  int pairs = 0;
  Eigen::Index later = 0;
  for (Eigen::Index k = 0; k < positions.size(); ++k) {
    while (later < positions.size() && positions(later) < positions(k) + lag) ++later;
    if (later == positions.size()) break;
    if (positions(later) != positions(k) + lag) continue;
    sum += centred(k) * centred(later);
    ++pairs;
  }
  return {pairs > 0 ? sum / pairs : 0, pairs};
}

EffectiveNumber effective_number(const Eigen::Ref<const Eigen::VectorXd>& values,
                                 const Eigen::Ref<const Eigen::VectorXi>& positions) {
  assert(values.size() == positions.size());
  constexpr Eigen::Index kMinPairs = 4;
  // Limit for a correlation, in standard deviations that it has if the values are uncorrelated.
  constexpr double kSigmas = 2;
  const auto count = static_cast<double>(values.size());
  if (values.size() < kMinPairs) return {count, count};
  const Eigen::VectorXd centred = values.array() - values.mean();
  const double variance = centred.squaredNorm() / count;
  if (!(variance > 0)) return {count, count};
  double squares = 0, sum = 0;
  for (int lag = 1; lag < values.size(); ++lag) {
    const LaggedProduct at = lagged_product(centred, positions, lag);
    const double correlation = at.mean / variance;
    if (at.pairs < kMinPairs || std::abs(correlation) * std::sqrt(at.pairs) < kSigmas) break;
    squares += at.pairs * correlation * correlation;
    sum += at.pairs * correlation;
  }
  const auto effective_count = [&](double dependence) {
    return count * count / std::max(count, count + 2 * dependence);
  };
  return {effective_count(squares), effective_count(sum)};
}

Figures compute_figures(const Eigen::Ref<const Eigen::VectorXd>& values) {
  const auto count = static_cast<double>(values.size());
  Figures figures{.count = static_cast<int>(values.size())};
  if (figures.count == 0) return figures;
  figures.mean = values.mean();
  figures.rmse = std::sqrt(values.squaredNorm() / count);
  figures.max_abs = values.cwiseAbs().maxCoeff();
  if (figures.count > 1) figures.std = std::sqrt((values.array() - figures.mean).square().sum() / (count - 1));
  return figures;
}

std::string format_figures(const Figures& figures) {
  constexpr int kDigits = 4;
  constexpr int kMostDecimals = 12;
  const double scale = figures.std > 0 ? figures.std : figures.max_abs;
  const int leading = scale > 0 ? static_cast<int>(std::floor(std::log10(scale))) : 0;
  const int decimals = std::clamp(kDigits - 1 - leading, 0, kMostDecimals);
  const double unit = std::pow(10.0, -decimals);
  const double mean = std::abs(figures.mean) < unit / 2 ? 0.0 : figures.mean;
  return fmt::format("std {:.{}f}, mean {:.{}f}, rmse {:.{}f}, max {:.{}f}", figures.std, decimals, mean, decimals,
                     figures.rmse, decimals, figures.max_abs, decimals);
}

Figures compute_figures(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters,
                        const std::vector<Eigen::Index>& rows) {
  assert(values.size() == static_cast<Eigen::Index>(rows.size()));
  Figures figures = compute_figures(values);
  figures.effective = effective_number(values, cluster_positions(clusters, rows));
  return figures;
}

Figures compute_figures(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(clusters.start_s.size()));
  std::iota(rows.begin(), rows.end(), 0);
  return compute_figures(values, clusters, rows);
}

double standard_error_of_std(const Figures& figures) {
  const bool known = figures.count > 1 && figures.effective.of_std > 0;
  return known ? figures.std / std::sqrt(2 * figures.effective.of_std) : std::numeric_limits<double>::quiet_NaN();
}

double standard_error_of_mean(const Figures& figures) {
  const bool known = figures.count > 1 && figures.effective.of_mean > 0;
  return known ? figures.std / std::sqrt(figures.effective.of_mean) : std::numeric_limits<double>::quiet_NaN();
}

Improvement improvement(double std_raw, double std_three_point, double std_multi_point) {
  Improvement result;
  result.three_point_from_original = 1 - std_three_point / std_raw;
  result.multi_point_from_original = 1 - std_multi_point / std_raw;
  result.paper_ratio = result.multi_point_from_original / result.three_point_from_original - 1;
  result.residual_reduction = 1 - std_multi_point / std_three_point;
  return result;
}

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
  // Excludes the first cluster of a run and the first after a gap.
  const std::vector<Eigen::Index> with_rate = finite_rows(clusters.rate_c_per_min);
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

}  // namespace gyrotherm::data
