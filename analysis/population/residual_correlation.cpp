// SPDX-License-Identifier: Apache-2.0
#include "analysis/population/residual_correlation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <set>

#include "analysis/data/distributions.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm::population {
namespace {

constexpr double kLeastEffective = 5;

int cluster_position(const data::Clusters& clusters, Eigen::Index row) {
  return static_cast<int>(std::lround(clusters.start_s(row) / clusters.length_s));
}

Result<void> check_axes(std::span<const AxisResidual> axes) {
  const auto refuse = [](const std::string& axis, std::string what) {
    return failure(FaultKind::usage, fmt::format("axis \"{}\"", axis), std::move(what));
  };
  if (axes.size() < 2) return failure(FaultKind::usage, "residuals", "at least two axes are needed");
  std::set<std::string> names;
  for (const AxisResidual& axis : axes) {
    const data::Clusters& clusters = axis.clusters;
    if (!names.insert(axis.axis).second) return refuse(axis.axis, "is given twice");
    if (clusters.length_s != axes.front().clusters.length_s) return refuse(axis.axis, "has a different cluster length");
    if (axis.residual_deg_per_h.size() != clusters.start_s.size()) {
      return refuse(axis.axis, fmt::format("has {} clusters and {} residuals", clusters.start_s.size(),
                                           axis.residual_deg_per_h.size()));
    }
    for (Eigen::Index k = 1; k < clusters.start_s.size(); ++k)
      if (cluster_position(clusters, k) <= cluster_position(clusters, k - 1))
        return refuse(axis.axis, "has clusters of several runs");
  }
  return {};
}

/// Returns ρ at lags of 1 … `lags` positions.
Eigen::VectorXd autocorrelations(const Eigen::VectorXd& values, const Eigen::VectorXi& positions, Eigen::Index lags) {
  const Eigen::VectorXd centred = values.array() - values.mean();
  const double variance = centred.squaredNorm() / static_cast<double>(values.size());
  Eigen::VectorXd all(lags);
  for (Eigen::Index lag = 1; lag <= lags; ++lag)
    all(lag - 1) = data::lagged_product(centred, positions, static_cast<int>(lag)).mean / variance;
  return all;
}

/// Counts the pairs of positions at each distance from 1 to `lags`.
Eigen::VectorXd count_pairs_by_lag(const Eigen::VectorXi& positions, Eigen::Index lags) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(positions.size());
  Eigen::VectorXd all(lags);
  for (Eigen::Index lag = 1; lag <= lags; ++lag)
    all(lag - 1) = data::lagged_product(ones, positions, static_cast<int>(lag)).pairs;
  return all;
}

struct CorrelatedPair {
  double r{}, effective{}, probability = 1;
  /// True if the pair has enough effective values for a test.
  bool is_usable{};
};

/// Correlates two axes at the positions that both have.
CorrelatedPair correlate_pair(const Eigen::MatrixXd& both, const Eigen::VectorXi& all_positions) {
  const auto rows = data::finite_rows(both);
  const Eigen::VectorXd a = both.col(0)(rows), b = both.col(1)(rows);
  const Eigen::VectorXi positions = all_positions(rows);
  const auto count = static_cast<double>(rows.size());
  const auto varies = [](const Eigen::VectorXd& values) {
    return values.size() > 1 && values.maxCoeff() > values.minCoeff();
  };
  CorrelatedPair pair{.r = data::pearson(a, b), .effective = count};
  if (!varies(a) || !varies(b)) return pair;
  const Eigen::Index lags = a.size() / 4;
  const double dependence =
      (count_pairs_by_lag(positions, lags).array() * autocorrelations(a, positions, lags).array() *
       autocorrelations(b, positions, lags).array())
          .sum();
  pair.effective = count * count / std::max(count, count + 2 * dependence);
  pair.is_usable = pair.effective >= kLeastEffective;
  if (!pair.is_usable) return pair;
  const double freedom = pair.effective - 2, left = 1 - pair.r * pair.r;
  if (!(left > 0)) {
    pair.probability = 0;
    return pair;
  }
  pair.probability = 2 * data::students_t_probability(-std::abs(pair.r) * std::sqrt(freedom / left), freedom);
  return pair;
}

}  // namespace

Result<AxisResiduals> align_residuals(std::span<const AxisResidual> axes) {
  if (const auto checked = check_axes(axes); !checked) return failure(checked.error());
  std::set<int> positions;
  for (const AxisResidual& axis : axes)
    for (Eigen::Index k = 0; k < axis.clusters.start_s.size(); ++k)
      positions.insert(cluster_position(axis.clusters, k));
  AxisResiduals all;
  const std::vector<int> rising(positions.begin(), positions.end());
  const auto rows = static_cast<Eigen::Index>(rising.size());
  all.positions = Eigen::Map<const Eigen::VectorXi>(rising.data(), rows);
  all.residual_deg_per_h.setConstant(rows, static_cast<Eigen::Index>(axes.size()),
                                     std::numeric_limits<double>::quiet_NaN());
  for (std::size_t j = 0; j < axes.size(); ++j) {
    all.axes.push_back(axes[j].axis);
    for (Eigen::Index k = 0; k < axes[j].clusters.start_s.size(); ++k) {
      const auto row = std::ranges::lower_bound(rising, cluster_position(axes[j].clusters, k)) - rising.begin();
      all.residual_deg_per_h(row, static_cast<Eigen::Index>(j)) = axes[j].residual_deg_per_h(k);
    }
  }
  return all;
}

ResidualCorrelation correlate_residuals(const AxisResiduals& residuals) {
  const Eigen::Index axes = residuals.residual_deg_per_h.cols();
  assert(residuals.positions.size() == residuals.residual_deg_per_h.rows());
  assert(static_cast<Eigen::Index>(residuals.axes.size()) == axes);
  ResidualCorrelation all{.axes = residuals.axes,
                          .correlation = Eigen::MatrixXd::Identity(axes, axes),
                          .effective = Eigen::MatrixXd::Zero(axes, axes),
                          .probability = Eigen::MatrixXd::Zero(axes, axes)};
  double sum = 0, smallest = 1;
  int pairs = 0;
  for (Eigen::Index i = 0; i < axes; ++i) {
    for (Eigen::Index j = i + 1; j < axes; ++j) {
      Eigen::MatrixXd both(residuals.positions.size(), 2);
      both << residuals.residual_deg_per_h.col(i), residuals.residual_deg_per_h.col(j);
      const CorrelatedPair pair = correlate_pair(both, residuals.positions);
      all.correlation(i, j) = all.correlation(j, i) = pair.r;
      all.effective(i, j) = all.effective(j, i) = pair.effective;
      all.probability(i, j) = all.probability(j, i) = pair.probability;
      if (!pair.is_usable) continue;
      const double z = std::atanh(std::clamp(pair.r, -1 + 1e-15, 1 - 1e-15));
      sum += (pair.effective - 3) * z * z;
      smallest = std::min(smallest, pair.probability);
      ++pairs;
    }
  }
  if (pairs == 0) return all;
  all.all_probability = data::chi_squared_exceeds(sum, pairs);
  all.largest_probability = std::min(1.0, smallest * pairs);
  return all;
}

}  // namespace gyrotherm::population
