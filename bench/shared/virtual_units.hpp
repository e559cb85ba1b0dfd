// SPDX-License-Identifier: Apache-2.0
/// Units of one type, each a virtual gyro with another seed: its ramp run, its random run and the true bias of the
/// latter.
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
  /// True bias of each cluster of the random run, °/h: all but the angle random walk and the effects of the read-out.
  Eigen::VectorXd random_truth_deg_per_h;
};

/// Loads rate-SEED.db and random-SEED.db of the seeds 1 … count of a folder, and simulates the random runs again for
/// their true bias. Prints progress on stderr.
[[nodiscard]] Result<std::vector<VirtualUnit>> load_units(const std::string& folder, int count);

/// Mean and standard error of at least two values.
struct MeanWithError {
  double mean{}, error{};
};
[[nodiscard]] MeanWithError with_error(const std::vector<double>& values);

[[nodiscard]] double root_mean_square(const Eigen::VectorXd& values);

}  // namespace gyrotherm::bench
