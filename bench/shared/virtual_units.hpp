// SPDX-License-Identifier: Apache-2.0
/// Units of one type, each a virtual gyro of another seed: its rate run, its random run and the truth of that.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// One unit in the chamber.
struct VirtualUnit {
  std::string name;
  data::RecordedRun rate, random;
  /// Of each cluster of the random run, °/h: all of its bias but the angle random walk and what the read-out does.
  Eigen::VectorXd random_truth_deg_per_h;
};

/// Loads rate-SEED.db and random-SEED.db of the seeds 1 … count of a folder, and has the laboratory live through the
/// random runs again for their truth. Says on stderr how it goes.
[[nodiscard]] Result<std::vector<VirtualUnit>> load_units(const std::string& folder, int count);

/// Mean and its standard error, of at least two values.
struct MeanWithError {
  double mean{}, error{};
};
[[nodiscard]] MeanWithError with_error(const std::vector<double>& values);

[[nodiscard]] double root_mean_square(const Eigen::VectorXd& values);

}  // namespace gyrotherm::bench
