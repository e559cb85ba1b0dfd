/// LIBSVM (Chang and Lin), the standing peer, from any build of its shared library: cache 200 MB, shrinking, tolerance
/// 1e-3.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>

#include "analysis/svm/tuning.hpp"
#include "bench/svr/judge.hpp"
#include "core/result.hpp"

struct svm_model;

namespace gyrotherm {

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

  [[nodiscard]] const std::string& library() const { return library_; }
  [[nodiscard]] int version() const { return version_; }

  [[nodiscard]] PeerSolution train(const SampleMatrix& x, const Eigen::VectorXd& y,
                                   const PeerParameters& parameters) const;
  /// Trains on each fold and predicts what it holds out.
  [[nodiscard]] Evaluated cross_validate(std::span<const TuningFold> folds, const PeerParameters& parameters) const;
  /// Points a second of svm_predict with the solution of one training, over the rows of `x`.
  [[nodiscard]] double predictions_per_second(const SampleMatrix& x, const Eigen::VectorXd& y,
                                              const PeerParameters& parameters) const;

 private:
  struct Functions;
  std::string library_;
  int version_{};
  std::shared_ptr<const Functions> functions_;
};

}  // namespace gyrotherm
