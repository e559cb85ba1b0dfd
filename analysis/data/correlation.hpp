/// Pearson's correlation of bias with every gradient (Table 3), temperature and temperature rate.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"

namespace gyrotherm {

struct Correlation {
  std::vector<std::string> names;  ///< thermometers, rows and columns of `gradient`
  Eigen::MatrixXd gradient;        ///< signed r of T_i − T_j with bias for i before j; antisymmetric, zero diagonal
  Eigen::VectorXd temperature;     ///< signed r of each T_i
  Eigen::VectorXd rate;            ///< signed r of each causal dT_i/dt
};

[[nodiscard]] double pearson(const Eigen::Ref<const Eigen::VectorXd>& a, const Eigen::Ref<const Eigen::VectorXd>& b);

/// Of the named thermometers, on these clusters alone; of rates, on those that have one.
[[nodiscard]] Correlation correlate(const Clusters& clusters, const std::vector<std::string>& names);

}  // namespace gyrotherm
