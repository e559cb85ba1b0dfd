// SPDX-License-Identifier: Apache-2.0
/// The two compared solvers. The peer is LIBSVM (Chang and Lin), from any build of its shared library: cache 200 MB,
/// shrinking, tolerance 1e-3. The other is this project's solver, called only through the public interface of
/// analysis/.
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

/// Solution of LIBSVM in the n-variable form.
struct PeerSolution {
  Eigen::VectorXd beta;
  double b{};
  double seconds{};  ///< svm_train, processor time
};

/// Result of one solver for one position of a tuning job.
struct Evaluated {
  /// Mean squared error over all held-out rows.
  double error{};
  double seconds{};  ///< processor time
};

class LibsvmPeer {
 public:
  /// Opens the library by path or name ("libsvm.so.3"). Fails with usage if it cannot be loaded or lacks a function.
  [[nodiscard]] static Result<LibsvmPeer> open(const std::string& library);

  [[nodiscard]] int version() const { return version_; }

  [[nodiscard]] PeerSolution train(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                   const PeerParameters& parameters) const;
  /// Trains on each fold and predicts its held-out rows.
  [[nodiscard]] Evaluated cross_validate(std::span<const svm::TuningFold> folds,
                                         const PeerParameters& parameters) const;
  /// Returns the points per second of svm_predict with the solution of one training, over the rows of `x`.
  [[nodiscard]] double predictions_per_second(const svm::SampleMatrix& x, const Eigen::VectorXd& y,
                                              const PeerParameters& parameters) const;

 private:
  struct Functions;
  int version_{};
  std::shared_ptr<const Functions> functions_;
};

/// Requested relative duality gap, and the much smaller gap of a reference solution.
inline constexpr double kGap = 1e-3;
inline constexpr double kReferenceGap = 1e-6;

/// Evaluates one position as the tuning job does, but never aborts it early. Runs a job of two particles in a box 1e-9
/// wide and returns the time of the second evaluation, because the first one includes the preparation of the job. Fails
/// like tune_svr(), or with numeric if a training misses its certificate.
[[nodiscard]] Result<Evaluated> cross_validate_own(std::span<const svm::TuningFold> folds,
                                                   const TracePosition& position);

/// Returns the cross-validation error of solutions with a relative gap of at most kReferenceGap, as computed in
/// judge.hpp. Predicts by a plain loop. Fails with numeric if the solution of a fold does not reach that gap.
[[nodiscard]] Result<double> reference_error(std::span<const svm::TuningFold> folds, const PeerParameters& parameters);

/// Returns the tuning options of the whole job: 20 particles, 30 iterations and no early end (620 evaluations), in the
/// peer's box.
[[nodiscard]] svm::TuningOptions whole_job(int threads);

}  // namespace gyrotherm::bench
