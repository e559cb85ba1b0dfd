/// What a new record knows before its first sample, from the program, the profile, the rig and the seed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "acquisition/record/run_info.hpp"
#include "rig/rig_file.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm {

/// The id of a dry run is derived from what determines it (program, profile, rig, seed); that of a real run is drawn.
[[nodiscard]] RunInfo run_info(std::string_view program_version, const Profile& profile, const RigFile& rig,
                               std::uint64_t seed, Duration started_utc);

/// A number of the profile's own: what draws the noise of a dry run of it.
[[nodiscard]] std::uint64_t run_number(const std::string& profile_text);

}  // namespace gyrotherm
