// SPDX-License-Identifier: Apache-2.0
/// Profiles that are read and checked before anything moves: against a rig, its controller, and the quantities of
/// reports.
#pragma once

#include <string>

#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Reads a profile from a file, or the shipped profile of that name, and checks it against the limits of the rig's
/// chamber, air and sensors. Adds the warm-ups that the rig requires. Without a rig, checks only the profile itself.
/// Fails with bad_file; the fault lists every error with its position.
[[nodiscard]] Result<profile::Profile> read_profile(const std::string& given, const rig::RigFile* rig);
/// Checks the text of a profile in the same way. Its errors are reported under `name`.
[[nodiscard]] Result<profile::Profile> parse_checked_profile(const rig::RigFile* rig, const std::string& profile_text,
                                                             const std::string& name);

/// Fails with out_of_range if the present limits of the chamber's controller exclude a set point of the profile or the
/// safe set point.
[[nodiscard]] Result<void> check_controller(const drivers::SetPointRange& limits, const profile::Profile& profile,
                                            const rig::RigFile& rig);

/// Fails with bad_file if the [accept] table of a profile names a quantity that reports do not have. `file` is the path
/// of the profile.
[[nodiscard]] Result<void> check_accept(const profile::Profile& profile, const std::string& file);

}  // namespace gyrotherm::app
