// SPDX-License-Identifier: Apache-2.0
/// Plan of folds: for each fold, the clusters that are held out together and the clusters used for training. Folds are
/// cycles, power-ons, whole records, all records of a program, or consecutive blocks with a guard gap. They are never
/// random clusters, because neighbouring clusters are nearly identical (docs/evaluation.md).
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
  /// records if there are at least kFewestForRecords records and none has a cycle, else cycles. A record without cycles
  /// and with several power-ons is cut into short blocks; see kShortBlockMinutes.
  automatic,
  cycles,
  starts,
  records,
  programs,
  blocks,
};

inline constexpr std::size_t kFewestForRecords = 3;

inline constexpr int kDefaultBlocks = 4;

/// Length of a block of a record with several power-ons. With a guard on both sides, each fold leaves out about 1.5 h.
/// Such a record is short, and has each condition only two or three times; a fold that leaves out a quarter of it would
/// measure an extrapolation that no use needs. Every fold learns from at least one power-on.
inline constexpr double kShortBlockMinutes = 45;

/// Default guard around blocks. The slowest time constant of the gyro in the reference simulation is 46 min. After a
/// fit that is linear in all temperatures, the residual of its ramp run is uncorrelated after 42 min.
inline constexpr double kDefaultGuardMinutes = 45;

struct FoldOptions {
  FoldKind kind = FoldKind::automatic;
  /// Number of blocks into which a record is cut, at least 2.
  int blocks = kDefaultBlocks;
  /// If not set, cycles and power-ons have no guard, and blocks have a guard of kDefaultGuardMinutes but at most half a
  /// block. Whole records need no guard.
  std::optional<double> guard_minutes = {};
  /// Profile name of each record. Required for FoldKind::programs.
  std::vector<std::string> programs = {};
};

/// Parses "auto", "cycles", "starts", "records", "programs", "blocks" or "blocks:6". Fails with usage.
[[nodiscard]] Result<FoldOptions> parse_folds(std::string_view text);

/// One fold. A cluster within the guard around the held-out clusters is in neither list.
struct Fold {
  /// Rows of the held-out and of the training clusters, in rising order.
  std::vector<Eigen::Index> held_out;
  std::vector<Eigen::Index> training;
};

struct FoldPlan {
  std::vector<Fold> folds;
  /// Summary: "leave one cycle out (4)", "4 consecutive blocks with a guard of 45 min".
  std::string statement;
};

/// Plans the folds of all records. Rows number the clusters of all records, one record after the other.
///
/// - cycles: one fold per cycle of each record. Clusters outside any cycle belong to the previous cycle, leading ones
/// to the first cycle. A record without cycles is cut into consecutive blocks, and so is a single record with a single
/// cycle.
/// - starts: one fold per power-on of each record. Each fold holds out a power-on with its warm-up, and learns from
/// others. A record with a single power-on is cut into blocks.
/// - records: each record is held out whole; all others are used for training.
/// - programs: all records of one program are held out together.
/// - blocks: every record is cut into blocks.
///
/// Fails with usage if a single record or program would be held out whole, if a record is too short to be cut, or if
/// the guard leaves a fold without training clusters.
[[nodiscard]] Result<FoldPlan> plan_folds(const std::vector<Clusters>& records, const FoldOptions& options = {});

/// Clusters used for training, and the folds for choices that use only these clusters.
struct TrainingSet {
  Clusters clusters;
  FoldPlan folds;
};

/// Restricts the training set to the given rows (rising). Removes the other clusters from its folds, and drops each
/// fold that has no held-out or no training clusters left.
[[nodiscard]] TrainingSet restrict_rows(const TrainingSet& training_set, const std::vector<Eigen::Index>& rows);

/// Returns the training set with at least two folds, which a choice on held-out clusters requires. If it has fewer,
/// replaces them by blocks. Fails with usage if there are too few clusters.
[[nodiscard]] Result<TrainingSet> ensure_two_folds(TrainingSet training_set);

}  // namespace gyrotherm::data
