// SPDX-License-Identifier: Apache-2.0
/// The real run on the virtual plant with the real store. Tests break one thing and observe the run second by second.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "sequencer/rig/rig.hpp"
#include "tests/sequencer/faults/memory_wires.hpp"
#include "tests/sequencer/faults/plant.hpp"
#include "tests/support/failing_vfs.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/run_harness.hpp"

namespace gyrotherm::faults {

/// Segments of a profile: 5 min at 20 °C, a 5 min ramp to 40 °C, half an hour at 40 °C, and a 5 min ramp back.
inline constexpr const char* kSteps = R"(
[[segment]]
kind = "hold"
at = 20
time = "5 min"
[[segment]]
kind = "ramp"
to = 40
rate = 4
[[segment]]
kind = "hold"
time = "30 min"
[[segment]]
kind = "ramp"
to = 20
rate = 4
)";

/// Settings of a BreakableRun. By default nothing is broken.
struct Setting {
  std::string segments = kSteps;
  /// Changes to profiles/rigs/virtual-reference.toml.
  std::function<void(rig::RigFile&)> rig = {};
  std::string chamber_map = "tests/sequencer/faults/chamber.toml";
  /// The controller carries out the profile.
  bool by_the_controller = false;
  /// Rows that the store keeps in memory; above 0 the record is on a disk and the store has a worker.
  std::int64_t rows_on_disk = 0;
};

/// An alarm in the record: "door (suspend): the chamber's door is open".
struct AlarmRecorded {
  std::string cause, reaction;
};

class BreakableRun {
 public:
  explicit BreakableRun(const Setting& setting);
  ~BreakableRun();
  BreakableRun(const BreakableRun&) = delete;
  BreakableRun& operator=(const BreakableRun&) = delete;

  Plant& plant() { return *plant_; }
  SimulatedClock& clock() { return clock_; }
  void fill_disk();
  void free_disk_space();
  /// Lets another program move the record's file.
  void move_record();
  [[nodiscard]] run::RunController& run_controller() { return harness_->run_controller(); }
  [[nodiscard]] const rig::RigFile& file() const { return file_; }
  void break_plant(const std::function<void(simulator::LaboratoryFaults&)>& fault) {
    fault(plant_->faults), plant_->apply_faults();
  }

  run::RunOutcome seconds(int count) { return harness_->seconds(count); }
  /// Lets the machine sleep for some seconds.
  void sleep(int count) { harness_->without_tick(count); }
  int until(const std::function<bool()>& so, int most) { return harness_->until(so, most); }
  int until(RunState state, int most) { return harness_->until(state, most); }

  [[nodiscard]] ProfilePosition progress() const { return harness_->progress(); }
  /// Returns the chamber's own set point, independent of any reading.
  [[nodiscard]] Celsius chamber_set_point() { return plant_->laboratory().set_point(); }
  /// Returns the texts of the active alarms.
  [[nodiscard]] std::vector<std::string> active_alarms() const {
    return harness_->run_controller().overview().faults_now;
  }

  /// Ends the program and reads the record.
  [[nodiscard]] record::Record record();
  [[nodiscard]] static std::vector<AlarmRecorded> alarms_in(const record::Record& record);

 private:
  void make_durable();

  rig::RigFile file_;
  profile::Profile profile_;
  std::optional<tests::TestFolder> folder_;
  std::string path_;
  std::optional<tests::FailingVfs> disk_;
  bool disk_is_full_ = false;
  SimulatedClock clock_;
  std::optional<Plant> plant_;
  std::optional<MemoryWires> wires_;
  std::unique_ptr<rig::Rig> rig_;
  std::unique_ptr<record::Store> store_;
  std::optional<tests::RunHarness> harness_;
};

}  // namespace gyrotherm::faults
