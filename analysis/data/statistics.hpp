// SPDX-License-Identifier: Apache-2.0
/// Statistics of a residual (eq. 11) with their standard errors, and the correlation of the bias with temperatures.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/form.hpp"

namespace gyrotherm::data {

/// Returns the rows that are finite in every column, in rising order.
template <class Values>
[[nodiscard]] std::vector<Eigen::Index> finite_rows(const Eigen::DenseBase<Values>& values) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    if (values.row(k).allFinite()) rows.push_back(k);
  }
  return rows;
}

/// Returns the position of each of the clusters, in cluster lengths; the positions rise. Positions of different records
/// are far apart.
[[nodiscard]] Eigen::VectorXi cluster_positions(const Clusters& clusters, const std::vector<Eigen::Index>& rows);

/// Mean product of values at a fixed lag.
struct LaggedProduct {
  /// Mean of the products. 0 if there are no pairs.
  double mean{};
  int pairs{};
};

/// Computes the mean product of two values whose positions differ by `lag` ≥ 0. The values are centred; their positions
/// are rising whole numbers. The mean divided by the variance of the values is the autocorrelation.
[[nodiscard]] LaggedProduct lagged_product(const Eigen::Ref<const Eigen::VectorXd>& centred,
                                           const Eigen::Ref<const Eigen::VectorXi>& positions, int lag);

/// Number of independent values with the same information as correlated ones. 0 if not computed.
struct EffectiveNumber {
  /// For the STD: n²/(n + 2 Σ n_k ρ_k²).
  double of_std{};
  /// For the mean: n²/(n + 2 Σ n_k ρ_k), at most n.
  double of_mean{};
};

/// Computes the effective number of values at rising whole `positions`. n_k pairs are k positions apart, and ρ_k is
/// their autocorrelation (Bartlett 1946, Gaussian values). The sums end before the first lag with |ρ_k| < 2/√n_k, the
/// 95 % limit for uncorrelated values. Both numbers are n if there are fewer than four values or if all are equal.
[[nodiscard]] EffectiveNumber effective_number(const Eigen::Ref<const Eigen::VectorXd>& values,
                                               const Eigen::Ref<const Eigen::VectorXi>& positions);

/// Statistics of cluster means, °/h. `std` is eq. 11 (N − 1) and 0 for a single value. All are 0 without values.
struct Figures {
  double std{}, mean{}, rmse{}, max_abs{};
  int count{};
  EffectiveNumber effective{};
};
[[nodiscard]] Figures compute_figures(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Returns "std 0.002247, mean 0.000000, rmse 0.002216, max 0.005088": all values with the decimals that give the STD
/// four digits, so that a rounding error of the mean reads 0.
[[nodiscard]] std::string format_figures(const Figures& figures);

/// Computes the statistics of values at the given clusters of a record, one value per cluster, with their effective
/// number. Values of different records are taken as uncorrelated.
[[nodiscard]] Figures compute_figures(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters,
                                      const std::vector<Eigen::Index>& rows);
/// Computes the statistics of values at all clusters of a record.
[[nodiscard]] Figures compute_figures(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters);

/// Computes the standard error of the STD, std/√(2 n_eff), and of the mean, std/√n_eff. NaN if the effective number is
/// unknown, or for a single value.
[[nodiscard]] double standard_error_of_std(const Figures& figures);
[[nodiscard]] double standard_error_of_mean(const Figures& figures);

/// Describes the statistics in the model, the report and the output of verify.
void describe(auto& form, Like<Figures> auto& figures) {
  form("std_deg_per_h", figures.std);
  form("mean_deg_per_h", figures.mean);
  form("rmse_deg_per_h", figures.rmse);
  form("max_abs_deg_per_h", figures.max_abs);
  form("count", figures.count);
  form("effective_count", known(figures.effective.of_std));
  form("effective_count_of_mean", known(figures.effective.of_mean));
  form.derived("std_error_deg_per_h", standard_error_of_std(figures));
  form.derived("mean_error_deg_per_h", standard_error_of_mean(figures));
}

/// Both definitions of "improvement" (errata 1.1).
struct Improvement {
  double three_point_from_original{};  ///< 1 − s_three/s_raw
  double multi_point_from_original{};  ///< 1 − s_multi/s_raw
  /// (multi_point_from_original − three_point_from_original)/three_point_from_original: the "improvement from
  /// traditional method" of the paper.
  double paper_ratio{};
  double residual_reduction{};  ///< 1 − s_multi/s_three
};
[[nodiscard]] Improvement improvement(double std_raw, double std_three_point, double std_multi_point);

/// Pearson correlation of the bias with every gradient (Table 3), temperature and temperature rate.
struct Correlation {
  /// Thermometers, in the order of the rows and columns of `gradient`.
  std::vector<std::string> names;
  /// Signed r of T_i − T_j with the bias for i before j. Antisymmetric with zero diagonal.
  Eigen::MatrixXd gradient;
  Eigen::VectorXd temperature;  ///< signed r of each T_i
  Eigen::VectorXd rate;         ///< signed r of each causal dT_i/dt
};

/// Returns Pearson's r of two vectors of equal length. Returns 0 if one of them does not vary.
[[nodiscard]] double pearson(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b);

/// Correlates the named thermometers with the bias on these clusters. Correlations with rates use only the clusters
/// that have a rate.
[[nodiscard]] Correlation correlate(const Clusters& clusters, const std::vector<std::string>& names);

}  // namespace gyrotherm::data
