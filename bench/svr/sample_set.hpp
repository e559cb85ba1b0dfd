/// The sets that solvers are compared on, and how they are cut into folds.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/svm/svr.hpp"
#include "analysis/svm/tuning.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Inputs and target, each of mean 0 and STD 1.
struct SampleSet {
  std::string name;
  SampleMatrix x;
  Eigen::VectorXd y;
};

/// FOLDER/NAME.bin as make_sets.py writes it: int32 n, int32 d, float64 X by row, float64 y. Fails with bad_file.
[[nodiscard]] Result<SampleSet> load_sample_set(const std::string& folder, const std::string& name);

/// Five folds of a fixed shuffle (Fisher–Yates, std::mt19937(12345)), so that every solver sees the same rows in the
/// same order. Shuffled folds measure time; they are no evaluation of a model.
[[nodiscard]] std::vector<TuningFold> shuffled_folds(const SampleSet& set);

}  // namespace gyrotherm
