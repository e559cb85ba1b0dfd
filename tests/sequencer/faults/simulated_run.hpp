// SPDX-License-Identifier: Apache-2.0
/// Simulated runs of a profile on a virtual rig, during schedules of faults.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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

/// The parsed files of a simulated run.
struct SimulatedSetup {
  profile::Profile profile;
  /// The same rig with its chamber on Modbus TCP and on Modbus RTU.
  rig::RigFile tcp, rtu;
  simulator::LaboratoryParameters laboratory;
};

/// Reads the files. `profile`: a path relative to the source tree; `rig`: the name of a shipped virtual rig. Ends the
/// program if a file cannot be read, because the files belong to the tests.
[[nodiscard]] SimulatedSetup simulated_setup(const std::string& profile, const std::string& rig = "virtual-reference");

/// Returns the run data of this profile on this virtual rig.
[[nodiscard]] record::RunInfo make_run_info(const profile::Profile& profile, const rig::RigFile& file);

// One run of a profile on the virtual plant during a schedule of faults. Run controller, I/O, driver logic and store
// are the real ones; the time is virtual, and every second is judged.

struct SimulatedRunSetting {
  std::uint64_t seed = 0;
  Schedule schedule;
  /// Folder of the record; unused if the record can be in memory.
  std::string folder;
  std::int64_t sync_every = 60;  ///< seconds
};

enum class Ending {
  complete,
  made_safe,
  stopped,
  ran_out_of_time,
  never_began,
  /// The record was destroyed before any program could notice it.
  lost_its_record,
};
[[nodiscard]] const char* name(Ending ending);

struct SimulatedRunReport {
  Violations violations;
  Ending ending = Ending::never_began;
  /// Length of the run.
  std::int64_t seconds = 0;
  /// Number of times that the program was started.
  std::int64_t lives = 0;
  std::uint64_t log_hash = 0;
  /// Longest time that rows waited for the disk, in seconds.
  std::int64_t longest_backlog = 0;
  /// Number of files of the record.
  int parts = 1;
  std::array<std::int64_t, 7> seconds_in_state{};
  std::vector<RowBrief> rows;
  /// Events that the program recorded, each text once for its kind.
  std::vector<Event> events;
  /// Blocks of a run that ends by itself, as chosen by its decisions.
  std::vector<std::string> blocks;
};

[[nodiscard]] SimulatedRunReport carry_out(const SimulatedSetup& ground, const SimulatedRunSetting& setting);

}  // namespace gyrotherm::faults
