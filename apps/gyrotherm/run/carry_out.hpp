// SPDX-License-Identifier: Apache-2.0
/// Execution of a run to its end: in real time on an event loop, or on a virtual rig as fast as possible.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/store.hpp"
#include "apps/console/command.hpp"
#include "apps/console/console.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/run/chamber_ownership.hpp"
#include "sequencer/run/run_controller.hpp"

namespace gyrotherm::app {

class RunDecider;

struct StartOptions {
  std::uint64_t seed{};        ///< virtual gyro and its noise
  std::uint64_t days_later{};  ///< additional age of a virtual gyro
  /// Loads the whole profile into the chamber's controller, which then executes it. If false, this program sends set
  /// points.
  bool upload = false;
  /// Starts although the air that a switched-off chamber shows contradicts all thermometers.
  bool accept_air = false;
  /// Goal of a run that ends by itself. Required if the profile has a table [until].
  std::optional<record::RunInfo::Goal> goal{};
  /// Pace of a virtual rig (pace.hpp). 0: as fast as possible.
  double pace{};
};

/// Adds the option --accept-air to a command that starts runs.
void add_accept_air_option(CLI::App& command, bool& accept);

/// Adds the option --days-later to a command that starts runs.
void add_days_later_option(CLI::App& command, std::uint64_t& days);

/// Replaces the common flag --json of a command that executes a run by one that also accepts `samples`.
void add_run_json_option(CLI::App& command, std::string& json);
/// Applies the value of that option.
void apply_run_json(Console& console, const std::string& json);

/// Checks what start_run() checks before it uses the rig: whether the record can be created, and whether the options
/// suit the rig. Fails with usage or storage.
[[nodiscard]] Result<void> check_may_start(const rig::RigFile& rig, const std::string& path,
                                           const StartOptions& options);

/// Records a new run of `profile` in the file `path`. The profile must have been read for this rig. Fails with usage
/// (--days-later on a real rig, among others), interrupted (the record is kept and can be resumed), interlock, an
/// instrument's fault at the start, or storage.
[[nodiscard]] Result<void> start_run(Console& console, const profile::Profile& profile, const rig::RigFile& rig,
                                     const std::string& path, const StartOptions& options);

struct ResumeOptions {
  /// Resumes even if the resume rule requires an operator's acceptance, because this option states that acceptance.
  bool accept = false;
  bool trust_commands = false;              ///< starts unconfirmed programs
  Duration gap = std::chrono::seconds(30);  ///< virtual rig: duration of the interruption
  /// Values of --unit, "u1=0042". The run keeps its units, so a difference is an error.
  std::vector<std::string> units{};
  /// Pace of a virtual rig (pace.hpp). 0: as fast as possible.
  double pace{};
};

/// Resumes an unfinished run in the same segment, without shortening a soak, and records the gap. Fails with
/// bad_file, before it uses any content of the record, if the hash chain is broken. Fails with refused if the record
/// names a program that this user has not confirmed for its rig file, unless `trust_commands` is set. Fails with usage
/// if the record contains other units than `units`. Fails with interrupted if judge_reentry() requires an operator,
/// unless `accept` is set.
[[nodiscard]] Result<void> resume_run(Console& console, const std::string& path, const ResumeOptions& options);

// Drivers of the tick: an event loop in real time, a plain loop in virtual time.

/// Active run and its objects. They must outlive drive_virtual() and drive_real().
struct ActiveRun {
  Console& console;
  const profile::Profile& profile;
  run::RunController& run_controller;
  rig::Rig& rig;
  record::Store& store;
  run::ChamberOwnership& ownership;
  const std::string& path;  ///< record
  /// Decides how a run continues that ends by itself; null for a profile with a fixed end.
  RunDecider* decider = nullptr;
  /// Pace of a virtual rig (pace.hpp). 0: as fast as possible.
  double pace{};
};

/// Ticks at the run's pace and syncs at least once a second of wall time, or after each tick that takes longer. Fails
/// with interrupted or storage.
[[nodiscard]] Result<run::RunOutcome> drive_virtual(const ActiveRun& run);

/// Ticks on each whole second of the rig's clock and syncs after each tick. If a tick is late, records the missed
/// seconds as a gap; later ticks are on whole seconds again. Sends a heartbeat to the watchdog at each tick.
[[nodiscard]] Result<run::RunOutcome> drive_real(const ActiveRun& run);

/// Waits up to three seconds until all rows are on the disk, and prints a warning if they are not.
void await_disk(const ActiveRun& run);
/// Waits until the end of the run is on the disk, because a record without it looks like that of a killed program.
/// Reports once a minute how much is missing. A further request to stop ends the wait, with a warning. Returns true if
/// the end is on the disk.
bool await_end_on_disk(const ActiveRun& run);

}  // namespace gyrotherm::app
