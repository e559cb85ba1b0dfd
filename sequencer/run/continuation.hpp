/// Where an interrupted run stood, out of its record, and how it goes on.
#pragma once

#include <cstdint>
#include <string>

#include "acquisition/record/record.hpp"
#include "core/result.hpp"
#include "rig/rig.hpp"
#include "rig/rig_file.hpp"
#include "sequencer/profile/machine.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/run/resume_rule.hpp"

namespace gyrotherm {

struct RunContinuation {
  RigFile rig;
  Profile profile;
  ProfileState state;        ///< of the first second after the gap: the profile's clock stands still in it
  std::int64_t last_slot{};  ///< that has a sample; −1: none
  std::int64_t recorded{};   ///< the last that has a sample or lies in a gap; −1: none
  InterruptedRun stood;
  std::string why_stopped;  ///< in words
  RigStart start{};         ///< what the rig is assembled with
};

/// `down`: how long ago the last recorded second was; a virtual rig was down for a second at least. `run`: the number
/// that draws the noise of a virtual rig's run. Fails with usage (finished, imported) or bad_file (the record's own
/// texts cannot be read any more).
[[nodiscard]] Result<RunContinuation> continuation_of(const Record& record, const std::string& path, Duration down,
                                                      std::uint64_t run);

}  // namespace gyrotherm
