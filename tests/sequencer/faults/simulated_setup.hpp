/// What simulated runs share: a profile, a rig, and what its world is made of.
#pragma once

#include <string>

#include "acquisition/record/run_info.hpp"
#include "rig/rig_file.hpp"
#include "sequencer/profile/profile.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm {

/// Parsed once.
struct SimulatedSetup {
  Profile profile;
  RigFile tcp, rtu;  ///< the same rig with its chamber on either framing
  LaboratoryParameters laboratory;
};

/// `profile`: a path relative to the source tree. Files that cannot be read end the program: they are the tests' own.
[[nodiscard]] SimulatedSetup simulated_setup(const std::string& profile);

/// What a record of this profile on this virtual rig knows.
[[nodiscard]] RunInfo info_of(const Profile& profile, const RigFile& file);

}  // namespace gyrotherm
