/// Pearson's correlation of bias with every gradient (Table 3), temperature and temperature rate; and the selection of
/// §4.3.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/clusters.hpp"
#include "analysis/features.hpp"

namespace gyrotherm {

struct Correlation {
  std::vector<std::string> names;  ///< thermometers, rows and columns of `gradient`
  Eigen::MatrixXd gradient;        ///< signed r of T_i − T_j with bias for i before j; antisymmetric, zero diagonal
  Eigen::VectorXd temperature;     ///< signed r of each T_i
  Eigen::VectorXd rate;            ///< signed r of each causal dT_i/dt
};

[[nodiscard]] double pearson(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b);

/// Of the named thermometers, on these clusters alone.
[[nodiscard]] Correlation correlate(const Clusters& clusters, const std::vector<std::string>& names);

struct Selection {
  std::vector<Term> terms;  ///< pairs i before j with |r| > threshold, or the stated fallback
  double threshold = 0.90;
  int rank{};
  bool fallback{};        ///< too few pairs passed: the differences with the first thermometer are used
  std::string statement;  ///< in words, for the report
};

/// Pairs with |r| > threshold. Where they span fewer dimensions than `least_rank`, the differences of the first
/// thermometer with all others are used instead, and the selection says so (errata 3.1).
[[nodiscard]] Selection select_pairs(const std::vector<std::string>& names, const Eigen::MatrixXd& r,
                                     double threshold = 0.90, int least_rank = 1);

}  // namespace gyrotherm
