// SPDX-License-Identifier: Apache-2.0
/// Units of one type. Each is a virtual gyro with its own seed, and has a ramp run and a random run with its true bias.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// One unit with its runs.
struct VirtualUnit {
  std::string name;
  data::RecordedRun rate, random;
  /// True bias of each cluster of the random run, °/h: everything except the angle random walk and the read-out
  /// effects.
  Eigen::VectorXd random_truth_deg_per_h;
};

/// Loads rate-SEED.db and random-SEED.db for the seeds 1 … count from a folder, and simulates the random runs again to
/// obtain their true bias. Prints progress on stderr.
[[nodiscard]] Result<std::vector<VirtualUnit>> load_units(const std::string& folder, int count);

/// Mean and standard error of at least two values.
struct MeanWithError {
  double mean{}, error{};
};
[[nodiscard]] MeanWithError mean_with_error(const std::vector<double>& values);

[[nodiscard]] double root_mean_square(const Eigen::VectorXd& values);

}  // namespace gyrotherm::bench
