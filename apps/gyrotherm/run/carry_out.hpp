// SPDX-License-Identifier: Apache-2.0
/// Conducts a run to its end: in real time on an event loop, on a virtual rig as fast as the machine allows.
#pragma once

#include <cstdint>
#include <string>

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

struct StartOptions {
  std::uint64_t seed{};        ///< of a virtual gyro and its noise
  std::uint64_t days_later{};  ///< how much older a virtual gyro is
  bool upload = false;  ///< the chamber's controller is given the whole profile and carries it out; else set points
};

/// The option --days-later of a command that starts runs.
void add_days_later(CLI::App& command, std::uint64_t& days);

/// Adds the option --json of a command that carries a run out, in place of the one that every command has: it may ask
/// for `samples`.
void add_json_of_run(CLI::App& command, std::string& json);
/// Applies the value of that option.
void apply_json_of_run(Console& console, const std::string& json);

/// Records a new run of a profile that was read for this rig into `path`. Fails with usage (a real gyro's days are not
/// ours to pass), interrupted (the record is kept; resume goes on), interlock, an instrument's fault at the start, or
/// storage.
[[nodiscard]] Result<void> start_run(Console& console, const profile::Profile& profile, const rig::RigFile& rig,
                                     const std::string& path, const StartOptions& options);

struct ResumeOptions {
  bool accept = false;                      ///< the operator allows what the resume rule leaves to people
  bool trust_commands = false;              ///< starts unconfirmed programs
  Duration gap = std::chrono::seconds(30);  ///< virtual rig: how long it was down
};

/// Continues an unfinished run: the same segment, no soak shortened, the gap in the record. Fails with bad_file before
/// anything of the record is used if its chain does not fit, with refused if it names a program that this user has not
/// confirmed for its rig file, unless trusted, and with interrupted if judge_reentry() asks, unless accepted.
[[nodiscard]] Result<void> resume_run(Console& console, const std::string& path, const ResumeOptions& options);

// What calls the tick: an event loop in real time, a plain loop in virtual time.

/// A run under way, and whom it concerns. All of them outlive the drive.
struct UnderWay {
  Console& console;
  const profile::Profile& profile;
  run::RunController& run_controller;
  rig::Rig& rig;
  record::Store& store;
  run::ChamberOwnership& ownership;
  const std::string& path;  ///< where the record is
};

/// Ticks as fast as the machine allows; syncs at least once a second of wall time. Fails with interrupted or storage.
[[nodiscard]] Result<run::RunOutcome> drive_virtual(const UnderWay& run);

/// Ticks on the whole seconds of the rig's clock, and syncs each. A late tick is a recorded gap; the grid does not
/// drift. At the end of each the watcher hears that this program lives.
[[nodiscard]] Result<run::RunOutcome> drive_real(const UnderWay& run);

/// Ends a run early: waits a few seconds until all of it is on the disk, and says so if it is not.
void await_disk(const UnderWay& run);

}  // namespace gyrotherm::app
