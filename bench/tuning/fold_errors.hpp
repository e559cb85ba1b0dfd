// SPDX-License-Identifier: Apache-2.0
/// Held-out error of a position over all folds, with its gradient.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "analysis/svm/kernel.hpp"
#include "analysis/svm/tuning.hpp"
#include "analysis/svm/warm_start.hpp"
#include "bench/tuning/hypergradient.hpp"

namespace gyrotherm::bench {

/// Solutions of the last position of one descent, from which its next trainings start.
using DescentHistory = std::vector<std::optional<std::pair<svm::SvrParameters, svm::SvrStart>>>;

struct LogError {
  double value{};  ///< ln of the mean squared error
  Position slope = Position::Zero();
};

class FoldErrors {
 public:
  /// Lays out the folds, which must have passed svm::check_folds().
  FoldErrors(std::vector<svm::TuningFold> folds, double relative_gap);

  /// Evaluates a position on all folds. Returns nothing if a training misses its certificate.
  [[nodiscard]] std::optional<LogError> evaluate(const Position& position, DescentHistory& history);
  [[nodiscard]] const std::vector<svm::TuningFold>& folds() const { return folds_; }
  [[nodiscard]] int evaluations() const { return evaluations_; }
  /// Returns the number of dimensions that the inputs span.
  [[nodiscard]] Eigen::Index dimensions() const { return training_.front().cols(); }

 private:
  [[nodiscard]] std::optional<SquaredError> evaluate_fold(std::size_t fold, const svm::SvrParameters& parameters,
                                                          DescentHistory& history);

  std::vector<svm::TuningFold> folds_;
  std::vector<svm::SampleMatrix> training_, held_out_;
  std::vector<svm::GaussianSamples> samples_;
  std::vector<std::optional<svm::FoldSeed>> seeds_;
  svm::SvrOptions options_;
  svm::KernelMemory memory_;
  double rows_ = 0;
  int evaluations_ = 0;
};

}  // namespace gyrotherm::bench
