// SPDX-License-Identifier: Apache-2.0
/// Profiles that were read and checked before anything moves: against a rig, its controller, and the figures of
/// reports.
#pragma once

#include <string>

#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Reads a profile, a file or the shipped one of that name, and checks it against what the rig's chamber can do, and
/// for soaks on sensors that it does not have. Without a rig it is checked by itself. Fails with bad_file, every
/// mistake with its place.
[[nodiscard]] Result<profile::Profile> read_profile(const std::string& given, const rig::RigFile* rig);
/// Does the same with the text of a profile; its mistakes are told under this name.
[[nodiscard]] Result<profile::Profile> profile_for(const rig::RigFile* rig, const std::string& written,
                                                   const std::string& name);

/// Fails with out_of_range if the chamber's controller, as it is set, does not take every set point of the profile and
/// the rig's safe one.
[[nodiscard]] Result<void> check_controller(const drivers::SetPointRange& limits, const profile::Profile& profile,
                                            const rig::RigFile& rig);

/// Checks that the [accept] table of a profile names figures of the report alone. `file` is the profile's. Fails with
/// bad_file.
[[nodiscard]] Result<void> check_accept(const profile::Profile& profile, const std::string& file);

}  // namespace gyrotherm::app
