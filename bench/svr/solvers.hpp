// SPDX-License-Identifier: Apache-2.0
/// The two that are compared. LIBSVM (Chang and Lin), the standing peer, from any build of its shared library: cache
/// 200 MB, shrinking, tolerance 1e-3; and our solver as the benchmark asks it, through the public face of analysis/
/// alone.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>

#include "analysis/svm/tuning.hpp"
#include "bench/svr/judge.hpp"
#include "bench/svr/tuning_material.hpp"
#include "core/result.hpp"

struct svm_model;

namespace gyrotherm::bench {

/// Its solution as it stands in the n-variable form.
struct PeerSolution {
  Eigen::VectorXd beta;
  double b{};
  double seconds{};  ///< of svm_train, processor time
};

/// What one solver made of one position of a tuning job.
struct Evaluated {
  double error{};    ///< mean squared error over all held-out rows
  double seconds{};  ///< processor time
};

class LibsvmPeer {
 public:
  /// The library by path or name ("libsvm.so.3"). Fails with usage if it cannot be loaded or lacks a function.
  [[nodiscard]] static Result<LibsvmPeer> open(const std::string& library);

  [[nodiscard]] int version() const { return version_; }

  [[nodiscard]] PeerSolution train(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                   const PeerParameters& parameters) const;
  /// Trains on each fold and predicts what it holds out.
  [[nodiscard]] Evaluated cross_validate(std::span<const svm::TuningFold> folds,
                                         const PeerParameters& parameters) const;
  /// Points a second of svm_predict with the solution of one training, over the rows of `x`.
  [[nodiscard]] double predictions_per_second(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                              const PeerParameters& parameters) const;

 private:
  struct Functions;
  int version_{};
  std::shared_ptr<const Functions> functions_;
};

/// The asked and, for a reference, the far tighter relative duality gap.
inline constexpr double kGap = 1e-3;
inline constexpr double kReferenceGap = 1e-6;

/// One position as our tuning job evaluates it, without abort. The seconds are those of the second of two evaluations
/// by a job of two particles in a box 1e-9 wide, so that what a job prepares once is not counted at each position.
/// Fails as tune_svr does; with numeric if a training misses its certificate.
[[nodiscard]] Result<Evaluated> cross_validate_own(std::span<const svm::TuningFold> folds,
                                                   const TracePosition& position);

/// The error of solutions whose relative gap is at most kReferenceGap by the judge, predicted by a plain loop. Fails
/// with numeric if a fold's solution is not that good.
[[nodiscard]] Result<double> reference_error(std::span<const svm::TuningFold> folds, const PeerParameters& parameters);

/// The tuning options of the whole job: 20 particles, 30 iterations and no early end, hence 620 evaluations, in the
/// peer's box.
[[nodiscard]] svm::TuningOptions whole_job(int threads);

}  // namespace gyrotherm::bench
