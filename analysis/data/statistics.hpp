// SPDX-License-Identifier: Apache-2.0
/// The figures by which a residual is judged: eq. 11, what it hides, and how well it is known; and how bias and
/// temperatures correlate.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/form.hpp"

namespace gyrotherm::data {

/// The rows that are finite in every column, rising.
template <class Values>
[[nodiscard]] std::vector<Eigen::Index> finite_rows(const Eigen::DenseBase<Values>& values) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    if (values.row(k).allFinite()) rows.push_back(k);
  }
  return rows;
}

/// What values have to do with those some places later.
struct LaggedProduct {
  double mean{};  ///< of the products; 0 of no pair
  int pairs{};
};

/// The mean product of values `lag` ≥ 0 places apart. The values are centred, and each stands at a whole place, rising:
/// over their variance it is their autocorrelation.
[[nodiscard]] LaggedProduct lagged_product(const Eigen::Ref<const Eigen::VectorXd>& centred,
                                           const Eigen::Ref<const Eigen::VectorXi>& places, int lag);

/// How many independent values tell as much as these, which depend on their neighbours; 0 if that was not asked.
struct EffectiveNumber {
  double of_std{};   ///< n²/(n + 2 Σ n_k ρ_k²): for the STD
  double of_mean{};  ///< n²/(n + 2 Σ n_k ρ_k), at most n: for the mean
};

/// The effective number of values that stand at whole `places`, rising: n_k pairs lie k places apart, and their
/// autocorrelation is ρ_k (Bartlett 1946, Gaussian values). The sums end before the first lag at which |ρ_k| < 2/√n_k,
/// chance to 95 %. Both are n where fewer than four values are given or they do not vary.
[[nodiscard]] EffectiveNumber effective_number(const Eigen::Ref<const Eigen::VectorXd>& values,
                                               const Eigen::Ref<const Eigen::VectorXi>& places);

/// The figures of cluster means, °/h. `std` is eq. 11 (N − 1), 0 of a single value; all are 0 of none.
struct Figures {
  double std{}, mean{}, rmse{}, max_abs{};
  int count{};
  EffectiveNumber effective{};
};
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values);

/// The figures of values at these clusters of a record, one each, with their effective number. Nothing is correlated
/// across two records.
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters,
                                 const std::vector<Eigen::Index>& rows);
/// The figures of values at all clusters of a record.
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters);

/// The standard error of the STD, std/√(2 n_eff), and that of the mean, std/√n_eff; NaN if the effective number is not
/// known, and of a single value, which does not say how it scatters.
[[nodiscard]] double std_error(const Figures& figures);
[[nodiscard]] double mean_error(const Figures& figures);

/// The form of figures wherever they are written: in the model, the report and what verify says.
void describe(auto& form, Like<Figures> auto& figures) {
  form("std_deg_per_h", figures.std);
  form("mean_deg_per_h", figures.mean);
  form("rmse_deg_per_h", figures.rmse);
  form("max_abs_deg_per_h", figures.max_abs);
  form("count", figures.count);
  form("effective_count", known(figures.effective.of_std));
  form("effective_count_of_mean", known(figures.effective.of_mean));
  form.derived("std_error_deg_per_h", std_error(figures));
  form.derived("mean_error_deg_per_h", mean_error(figures));
}

/// Both ways of saying "improvement" (errata 1.1).
struct Improvement {
  double three_point_from_original{};  ///< 1 − s_three/s_raw
  double multi_point_from_original{};  ///< 1 − s_multi/s_raw
  double paper_ratio{};  ///< (multi − three)/three of the two above: the paper's "improvement from traditional method"
  double residual_reduction{};  ///< 1 − s_multi/s_three
};
[[nodiscard]] Improvement improvement(double std_raw, double std_three_point, double std_multi_point);

/// Pearson's correlation of bias with every gradient (Table 3), temperature and temperature rate.
struct Correlation {
  std::vector<std::string> names;  ///< thermometers, rows and columns of `gradient`
  Eigen::MatrixXd gradient;        ///< signed r of T_i − T_j with bias for i before j; antisymmetric, zero diagonal
  Eigen::VectorXd temperature;     ///< signed r of each T_i
  Eigen::VectorXd rate;            ///< signed r of each causal dT_i/dt
};

/// Pearson's r of two rows of numbers of one length; 0 if one of them does not vary.
[[nodiscard]] double pearson(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b);

/// Correlates the named thermometers on these clusters alone; rates on the clusters that have one.
[[nodiscard]] Correlation correlate(const Clusters& clusters, const std::vector<std::string>& names);

}  // namespace gyrotherm::data
