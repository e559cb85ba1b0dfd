// SPDX-License-Identifier: Apache-2.0
/// What solvers are compared on: sets, how they are cut into folds, and the positions of a tuning job, kept as text so
/// that every solver can be asked the same questions.
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

/// FOLDER/NAME.bin as make_sets.py writes it: int32 n, int32 d, float64 X by row, float64 y. Fails with bad_file.
[[nodiscard]] Result<SampleSet> load_sample_set(const std::string& folder, const std::string& name);

/// Five folds of a fixed shuffle (Fisher–Yates, std::mt19937(12345)), so that every solver sees the same rows in the
/// same order. Shuffled folds measure time; they are no evaluation of a model.
[[nodiscard]] std::vector<svm::TuningFold> shuffled_folds(const SampleSet& set);

/// One evaluation of the job: where, and what the peer made of it.
struct TracePosition {
  double log2_c{};
  double log2_gamma{};
  double log2_epsilon{};
  double error{};    ///< five-fold mean squared error
  double seconds{};  ///< it took when the trace was made; not used in a comparison

  [[nodiscard]] PeerParameters parameters() const;
};

/// "log2 C, log2 γ, log2 ε, error, seconds" by line, in the order of evaluation; '#' begins a remark. Fails with
/// bad_file, with file:line.
[[nodiscard]] Result<std::vector<TracePosition>> load_trace(const std::string& path);
[[nodiscard]] std::string line_of(const TracePosition& position);

/// `count` positions at equal stride over the whole job, from the middle of the first stride; all if there are fewer.
[[nodiscard]] std::vector<TracePosition> spread_over(const std::vector<TracePosition>& trace, std::size_t count);

/// Best error of our job over the peer's: no more than this.
inline constexpr double kBestErrorRatio = 1.01;

struct TuningMaterial {
  SampleSet set;
  std::vector<svm::TuningFold> folds;
  std::vector<TracePosition> trace;

  [[nodiscard]] const TracePosition& best() const;  ///< of the trace: where the job ended
  /// "n=600: figure".
  [[nodiscard]] std::string name(const std::string& figure) const;
};

/// The set `name` of one folder and its trace, NAME.trace, of another. Fails with bad_file.
[[nodiscard]] Result<TuningMaterial> tuning_material(const std::string& data, const std::string& traces,
                                                     const std::string& name);

}  // namespace gyrotherm::bench
