// SPDX-License-Identifier: Apache-2.0
/// What simulated runs share: a profile, a rig, and what its world is made of.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/record/run_info.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/run/run_controller.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "tests/sequencer/faults/disk.hpp"
#include "tests/sequencer/faults/fault_injector.hpp"
#include "tests/sequencer/faults/invariants.hpp"
#include "tests/sequencer/faults/memory_wires.hpp"
#include "tests/sequencer/faults/operators.hpp"
#include "tests/sequencer/faults/plant.hpp"
#include "tests/sequencer/faults/recording_store.hpp"
#include "tests/sequencer/faults/schedule.hpp"

namespace gyrotherm::faults {

/// Parsed once.
struct SimulatedSetup {
  profile::Profile profile;
  rig::RigFile tcp, rtu;  ///< the same rig with its chamber on either framing
  simulator::LaboratoryParameters laboratory;
};

/// `profile`: a path relative to the source tree; `rig`: the name of a shipped virtual rig. Files that cannot be read
/// end the program: they are the tests' own.
[[nodiscard]] SimulatedSetup simulated_setup(const std::string& profile, const std::string& rig = "virtual-reference");

/// What a record of this profile on this virtual rig knows.
[[nodiscard]] record::RunInfo info_of(const profile::Profile& profile, const rig::RigFile& file);

// One run of a profile on the virtual plant while a schedule of injected faults goes on: the real run, io,
// drivers' logic and store, in virtual time, judged every second.

struct SimulatedRunSetting {
  std::uint64_t seed = 0;
  Schedule schedule;
  std::string folder;            ///< for the record; in memory if it can be
  std::int64_t sync_every = 60;  ///< seconds
};

enum class Ending {
  complete,
  made_safe,
  stopped,
  ran_out_of_time,
  never_began,
  lost_its_record,  ///< destroyed while no program could have seen it
};
[[nodiscard]] const char* name(Ending ending);

struct SimulatedRunReport {
  Violations violations;
  Ending ending = Ending::never_began;
  std::int64_t seconds = 0;  ///< of the run
  std::int64_t lives = 0;    ///< of the program
  std::uint64_t log_hash = 0;
  std::int64_t longest_backlog = 0;  ///< seconds that waited for the disk
  int parts = 1;                     ///< files of the record
  std::array<std::int64_t, 7> seconds_in_state{};
  std::vector<RowBrief> rows;
};

[[nodiscard]] SimulatedRunReport carry_out(const SimulatedSetup& ground, const SimulatedRunSetting& setting);

}  // namespace gyrotherm::faults
