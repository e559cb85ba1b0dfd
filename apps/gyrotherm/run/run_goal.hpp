// SPDX-License-Identifier: Apache-2.0
/// The goal of a run that ends by itself: the target uncertainty, and the files that the table `[until]` names.
#pragma once

#include <optional>
#include <string>

#include "acquisition/record/run_info.hpp"
#include "analysis/planning/assessment.hpp"
#include "core/result.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::app {

/// Reads the mission and the prior of a profile, which was read as `given`, and checks that they can be used. Names are
/// relative to the folder of the profile; the mission may also be a shipped profile. `u_deg_per_h` replaces the target
/// of the profile. Returns nothing for a profile without `[until]`. Fails with usage if such a profile has a target
/// from the command line, or if the target is not a positive number, and with bad_file if a file cannot be used.
[[nodiscard]] Result<std::optional<record::RunInfo::Goal>> read_goal(const profile::Profile& profile,
                                                                     const std::string& given,
                                                                     const std::optional<double>& u_deg_per_h);

/// Fails with usage if a profile with `[until]` is started without a goal, or uploaded to a controller.
[[nodiscard]] Result<void> check_goal(const profile::Profile& profile, const std::optional<record::RunInfo::Goal>& goal,
                                      bool upload);

/// Describes a goal and the longest duration, for the record.
[[nodiscard]] std::string describe_goal(const profile::Profile& profile, const record::RunInfo::Goal& goal);

/// Returns the set points of segments that begin at `from`, as means over clusters. The number of power-ons
/// begins with the first segment that has the unit on. A part of a cluster at the end is omitted.
[[nodiscard]] planning::ProgramPath program_path(std::span<const profile::Segment> segments, Celsius from);

/// Returns the path of a profile, without the blocks that a run could add.
[[nodiscard]] planning::ProgramPath program_path(const profile::Profile& profile);

/// Returns the path of the mission. Fails with bad_file.
[[nodiscard]] Result<planning::ProgramPath> mission_path(const record::RunInfo::Goal& goal);

}  // namespace gyrotherm::app
