// SPDX-License-Identifier: Apache-2.0
/// What calls the tick: an event loop in real time, a plain loop in virtual time.
#pragma once

#include <string>

#include "acquisition/record/store.hpp"
#include "app/console.hpp"
#include "core/result.hpp"
#include "rig/rig.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/run/chamber_ownership.hpp"
#include "sequencer/run/run_controller.hpp"

namespace gyrotherm::app {

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
