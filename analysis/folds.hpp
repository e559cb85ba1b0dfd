/// Which clusters are held out together: cycles, since random folds of autocorrelated data flatter.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "analysis/clusters.hpp"
#include "core/result.hpp"

namespace gyrotherm {

struct FoldPlan {
  std::vector<int> fold;  ///< of each cluster of all records, one after the other
  int count{};
  std::string statement;  ///< "leave one cycle out (4)", "4 consecutive blocks"
};

/// A fold per cycle of each record; clusters outside any cycle go with the cycle before them, the first ones with the
/// first. A record of fewer than two cycles is cut into four consecutive blocks. Fails with usage if it has fewer than
/// eight clusters.
[[nodiscard]] Result<FoldPlan> plan_folds(const std::vector<Clusters>& records);

/// Rows inside a fold, and outside it, in order.
[[nodiscard]] std::vector<Eigen::Index> rows_in(const FoldPlan& plan, int fold);
[[nodiscard]] std::vector<Eigen::Index> rows_outside(const FoldPlan& plan, int fold);

}  // namespace gyrotherm
