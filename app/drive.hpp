/// What calls the tick: an event loop in real time, a plain loop in virtual time.
#pragma once

#include "acquisition/store.hpp"
#include "app/console.hpp"
#include "core/result.hpp"
#include "rig/experiment.hpp"
#include "rig/rig.hpp"
#include "sequencer/profile.hpp"

namespace gyrotherm {

/// Ticks as fast as the machine allows; syncs at least once a second of wall time. Fails with interrupted or storage.
[[nodiscard]] Result<Outcome> drive_virtual(Console& console, const Profile& profile, Experiment& experiment, Rig& rig,
                                            Store& store);

/// Ticks on the whole seconds of the rig's clock, and syncs each. A late tick is a recorded gap; the grid does not
/// drift.
[[nodiscard]] Result<Outcome> drive_real(Console& console, const Profile& profile, Experiment& experiment, Rig& rig,
                                         Store& store);

}  // namespace gyrotherm
