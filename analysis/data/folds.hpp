// SPDX-License-Identifier: Apache-2.0
/// Which clusters are held out together, and which are then learnt from: cycles, whole records, all records of a
/// program, or consecutive blocks with a guard gap. Never clusters at random: neighbours are nearly copies of each
/// other (docs/evaluation.md).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "core/result.hpp"

namespace gyrotherm::data {

enum class FoldKind {
  automatic,  ///< records where there are kFewestForRecords or more and none of them has a cycle, else cycles
  cycles,
  records,
  programs,
  blocks,
};

inline constexpr std::size_t kFewestForRecords = 3;

inline constexpr int kDefaultBlocks = 4;

/// The guard around blocks where none is asked for: the slowest time constant of the reference simulation's gyro is 46
/// min, and what a straight line in all temperatures leaves of its rate run is uncorrelated after 42 min.
inline constexpr double kDefaultGuardMinutes = 45;

struct FoldOptions {
  FoldKind kind = FoldKind::automatic;
  int blocks = kDefaultBlocks;  ///< ≥ 2, of each record that is cut into blocks
  /// Nothing: none between cycles; around blocks kDefaultGuardMinutes, but at most half a block. Whole records need
  /// none.
  std::optional<double> guard_minutes = {};
  std::vector<std::string> programs = {};  ///< the profile of each record, where they are held out by programs
};

/// Reads "auto", "cycles", "records", "programs", "blocks" or "blocks:6". Fails with usage.
[[nodiscard]] Result<FoldOptions> parse_folds(std::string_view text);

/// One fold. A cluster within the guard of what is held out is on neither side.
struct Fold {
  std::vector<Eigen::Index> held_out;  ///< rising
  std::vector<Eigen::Index> training;  ///< rising
};

struct FoldPlan {
  std::vector<Fold> folds;
  std::string statement;  ///< "leave one cycle out (4)", "4 consecutive blocks with a guard of 45 min"
};

/// Plans the folds of all records. By cycles there is a fold per cycle of each record; clusters outside any cycle go
/// with the cycle before them, the first ones with the first; a record without cycles is cut into consecutive blocks,
/// and so is the only cycle of a single record. By records each is held out whole, and learnt from are all others. By
/// programs all records of one program are held out together. By blocks every record is cut. Rows number the clusters
/// of all records, one after the other. Fails with usage if a single record or program is to be held out whole, a
/// record is too short to be cut, or the guard leaves a fold nothing to learn from.
[[nodiscard]] Result<FoldPlan> plan_folds(const std::vector<Clusters>& records, const FoldOptions& options = {});

/// Clusters to learn from, and how they are held out among themselves where something has to be chosen on them alone.
struct TrainingSet {
  Clusters clusters;
  FoldPlan folds;
};

/// What the training set leaves at these rows (rising): its folds without the other clusters, and without the folds
/// that have then nothing on one side.
[[nodiscard]] TrainingSet within(const TrainingSet& training_set, const std::vector<Eigen::Index>& rows);

/// The training set as it is if it has two folds, as a choice on held-out clusters needs; else with its clusters cut
/// into blocks. Fails with usage if they are too few for that.
[[nodiscard]] Result<TrainingSet> with_two_folds(TrainingSet training_set);

}  // namespace gyrotherm::data
