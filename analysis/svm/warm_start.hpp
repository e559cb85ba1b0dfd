// SPDX-License-Identifier: Apache-2.0
/// Start of a training from the solution of a similar one: another fold at the same position, or another position of
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

/// Mapping of the solution of one fold to the rows of another (alpha seeding: DeCoste, Wagstaff, KDD 2000; Wen et al.,
/// AAAI 2017). Rows in both training sets keep their β. If a row is only in the training set of `from`, its β is added
/// to the nearest rows that are only in the training set of `to`, as far as their bounds allow.
class FoldSeed {
 public:
  /// Returns no value if the folds do not list their rows or have different inputs.
  [[nodiscard]] static std::optional<FoldSeed> between(const TuningFold& from, const TuningFold& to);
  /// Returns the start for the training of `to`, given the solution of `from`. The sum of its β may differ from zero.
  [[nodiscard]] SvrStart start(const SvrStart& solved) const;

 private:
  static constexpr int kNeighbours = 8;
  struct RemovedRow {
    /// Row of `from`.
    Eigen::Index row;
    /// Nearest rows of `to`, the nearest first. Unused entries are −1.
    std::array<Eigen::Index, kNeighbours> nearest_rows;
  };
  /// Row of `from` for each row of `to`, or −1.
  std::vector<Eigen::Index> shared_;
  std::vector<RemovedRow> removed_;
};

/// Returns a feasible β of the problem near `start`. Scales `start` to the bound of the problem, sets points near the
/// bound exactly to it, and makes the sum zero by shifting points that are not at a bound. Returns no value if that is
/// impossible.
[[nodiscard]] std::optional<Eigen::VectorXd> feasible_start(const SvrProblem& problem, const SvrStart& start);

/// Returns the distance between two positions for warm starts: octaves of C, plus twice the octaves of σ.
[[nodiscard]] double octaves_between(const SvrParameters& a, const SvrParameters& b);

}  // namespace gyrotherm::svm
