// SPDX-License-Identifier: Apache-2.0
/// Where a training begins that resembles one already solved: another fold of the same position, or another position of
/// the same fold.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "analysis/svm/svr.hpp"
#include "analysis/svm/svr_problem.hpp"

namespace gyrotherm::svm {

struct TuningFold;

/// The rows of one fold in the solution of another: the rows that both learn from keep their β, and each β of a row
/// that is left out now goes to the nearest rows that were left out then, as far as their bounds allow (alpha seeding:
/// DeCoste, Wagstaff, KDD 2000; Wen et al., AAAI 2017).
class FoldSeed {
 public:
  /// None if the folds do not say which rows they are of, or see different inputs.
  [[nodiscard]] static std::optional<FoldSeed> between(const TuningFold& from, const TuningFold& to);
  /// Where the training of `to` begins, given the solution of `from`. Its sum need not be zero.
  [[nodiscard]] SvrStart start(const SvrStart& solved) const;

 private:
  static constexpr int kNeighbours = 8;
  struct Removed {
    Eigen::Index row;                                    ///< of `from`
    std::array<Eigen::Index, kNeighbours> nearest_rows;  ///< of `to`, the nearest first; −1 where there is none
  };
  std::vector<Eigen::Index> shared_;  ///< for each row of `to` that of `from`, or −1
  std::vector<Removed> removed_;
};

/// A feasible β of the problem near `start`: scaled as the bound is, clipped to it, and its sum made zero by the points
/// that are at no bound. None if they cannot.
[[nodiscard]] std::optional<Eigen::VectorXd> feasible_start(const SvrProblem& problem, const SvrStart& start);

/// How far two positions are from each other as warm starts see it: octaves of C, and twice those of σ.
[[nodiscard]] double octaves_between(const SvrParameters& a, const SvrParameters& b);

}  // namespace gyrotherm::svm
