// SPDX-License-Identifier: Apache-2.0
/// Material of the comparison: sets, their folds, and the positions of a tuning job. The positions are stored as text,
/// so every solver receives the same ones.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/svm/svr.hpp"
#include "analysis/svm/tuning.hpp"
#include "bench/svr/judge.hpp"
#include "core/result.hpp"

namespace gyrotherm::bench {

/// Inputs and target, each of mean 0 and STD 1.
struct SampleSet {
  std::string name;
  svm::SampleMatrix x;
  Eigen::VectorXd y;
};

/// Loads FOLDER/NAME.bin as written by make_sets.py: int32 n, int32 d, float64 X by row, float64 y. Fails with
/// bad_file.
[[nodiscard]] Result<SampleSet> load_sample_set(const std::string& folder, const std::string& name);

/// Returns five folds of a fixed shuffle (Fisher–Yates, std::mt19937(12345)), which gives every solver the same rows in
/// the same order. Shuffled folds are for measuring time; they are not suitable for evaluating a model.
[[nodiscard]] std::vector<svm::TuningFold> shuffled_folds(const SampleSet& set);

/// One evaluation of the job: its position and the peer's result.
struct TracePosition {
  double log2_c{};
  double log2_gamma{};
  double log2_epsilon{};
  double error{};  ///< five-fold mean squared error
  /// Time measured when the trace was made; not used in a comparison.
  double seconds{};

  [[nodiscard]] PeerParameters parameters() const;
};

/// Loads lines of "log2 C, log2 γ, log2 ε, error, seconds", in the order of evaluation; '#' begins a comment. Fails
/// with bad_file, with file:line.
[[nodiscard]] Result<std::vector<TracePosition>> load_trace(const std::string& path);
[[nodiscard]] std::string trace_line(const TracePosition& position);

/// Returns `count` positions, spaced evenly over the whole job from the middle of the first interval. Returns all
/// positions if there are fewer.
[[nodiscard]] std::vector<TracePosition> evenly_spaced(const std::vector<TracePosition>& trace, std::size_t count);

/// Greatest permitted ratio of this job's best error to the peer's.
inline constexpr double kBestErrorRatio = 1.01;

struct TuningMaterial {
  SampleSet set;
  std::vector<svm::TuningFold> folds;
  std::vector<TracePosition> trace;

  /// Returns the position with the best error of the trace, which is the result of the job.
  [[nodiscard]] const TracePosition& best() const;
  /// Returns "n=600: figure".
  [[nodiscard]] std::string name(const std::string& figure) const;
};

/// Loads the set `name` from one folder and its trace, NAME.trace, from another. Fails with bad_file.
[[nodiscard]] Result<TuningMaterial> tuning_material(const std::string& data, const std::string& traces,
                                                     const std::string& name);

}  // namespace gyrotherm::bench
