/// The figures by which a residual is judged: eq. 11, what it hides, and how well it is known.
#pragma once

#include <Eigen/Core>

#include "analysis/data/clusters.hpp"

namespace gyrotherm {

/// How many independent values tell as much as these, which depend on their neighbours; 0 if that was not asked.
struct EffectiveNumber {
  double of_std{};   ///< n²/(n + 2 Σ n_k ρ_k²): for the STD
  double of_mean{};  ///< n²/(n + 2 Σ n_k ρ_k), at most n: for the mean
};

/// Of values that stand at whole `places`, rising: n_k pairs lie k places apart, and their autocorrelation is ρ_k
/// (Bartlett 1946, Gaussian values). The sums end before the first lag at which |ρ_k| < 2/√n_k, chance to 95 %. Both
/// are n where fewer than four values are given or they do not vary.
[[nodiscard]] EffectiveNumber effective_number(const Eigen::Ref<const Eigen::VectorXd>& values,
                                               const Eigen::Ref<const Eigen::VectorXi>& places);

/// Of cluster means, °/h. `std` is eq. 11 (N − 1), 0 of a single value; all are 0 of none.
struct Figures {
  double std{}, mean{}, rmse{}, max_abs{};
  int count{};
  EffectiveNumber effective{};
};
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values);

/// The same of values at these clusters of a record, one each, with their effective number. Nothing is correlated
/// across two records.
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters,
                                 const std::vector<Eigen::Index>& rows);
/// Of all clusters.
[[nodiscard]] Figures figures_of(const Eigen::Ref<const Eigen::VectorXd>& values, const Clusters& clusters);

/// Standard error of the STD, std/√(2 n_eff), and of the mean, std/√n_eff; NaN if the effective number is not known.
[[nodiscard]] double std_error(const Figures& figures);
[[nodiscard]] double mean_error(const Figures& figures);

/// Both ways of saying "improvement" (errata 1.1).
struct Improvement {
  double three_point_from_original{};  ///< 1 − s_three/s_raw
  double multi_point_from_original{};  ///< 1 − s_multi/s_raw
  double paper_ratio{};  ///< (multi − three)/three of the two above: the paper's "improvement from traditional method"
  double residual_reduction{};  ///< 1 − s_multi/s_three
};
[[nodiscard]] Improvement improvement(double std_raw, double std_three_point, double std_multi_point);

}  // namespace gyrotherm
