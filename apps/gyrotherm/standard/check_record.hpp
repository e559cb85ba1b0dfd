// SPDX-License-Identifier: Apache-2.0
/// The history of check runs beside a rig file, and the entry that a record adds to it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/assurance/history.hpp"
#include "apps/console/command.hpp"
#include "core/file.hpp"
#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// A rig with a golden gyro, and the text of its history; empty before the first check run.
struct StandardOfRig {
  rig::RigFile rig;
  std::string path{};  ///< path of the history
  std::string text{};
  Descriptor lock{};  ///< held while the history is changed
};

enum class HistoryAccess { read, change };

/// Reads the rig and its history, if there is one. To change it, first waits until no other program changes it. Fails
/// with bad_file, with usage if the rig has no golden gyro or its settings differ from those with which the history
/// began, or like lock_history().
[[nodiscard]] Result<StandardOfRig> open_standard(const std::string& rig, HistoryAccess access);

/// Returns the path of a history: relative to the folder of the rig file.
[[nodiscard]] std::string history_path(const std::string& history, const std::string& rig_file);

/// Returns the path of the history that the rig file of a real run names, if that file exists.
[[nodiscard]] std::optional<std::string> find_history(const record::RunInfo& info);

/// Measures the records that the history does not contain yet and appends them, in order of their time. Fails like
/// measure_check_run(); with usage if a record is of another rig, another profile or another unit, or older than the
/// last check run.
[[nodiscard]] Result<void> append_records(Console& console, StandardOfRig& standard,
                                          const std::vector<std::string>& records, bool unverified);

/// Returns what a draft report must state about the history of the rig on which its records were made: empty if every
/// check run is in control or explained, or if all runs, which started at `started_utc`, are older than the last check
/// run before the first open one.
[[nodiscard]] std::optional<std::string> describe_open_check(const assurance::History& history,
                                                             const std::vector<std::string>& started_utc);

}  // namespace gyrotherm::app
