// SPDX-License-Identifier: Apache-2.0
/// The real run on the virtual plant, its record kept by the real store: for breaking one thing and looking at
/// what follows, a second at a time.
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

/// Segments of a profile: 20 °C for 5 min, to 40 °C in another 5, there for half an hour, back.
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

/// What such a run is given; nothing of it is broken.
struct Setting {
  std::string segments = kSteps;
  std::function<void(rig::RigFile&)> rig = {};  ///< what it has otherwise than profiles/rigs/virtual-reference.toml
  std::string chamber_map = "tests/sequencer/faults/chamber.toml";
  bool by_the_controller = false;  ///< it is given the profile
  std::int64_t rows_on_disk = 0;   ///< a record on a disk, by a store with a worker that keeps so many rows in memory
};

/// An alarm as the record has it: "door (suspend): the chamber's door is open".
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
  void make_room_on_disk();
  /// Another program moves its file.
  void take_record_away();
  [[nodiscard]] run::RunController& run_controller() { return harness_->run_controller(); }
  [[nodiscard]] const rig::RigFile& file() const { return file_; }
  void break_plant(const std::function<void(simulator::LaboratoryFaults&)>& fault) {
    fault(plant_->faults), plant_->apply_faults();
  }

  run::RunOutcome seconds(int count) { return harness_->seconds(count); }
  /// The machine sleeps for some seconds.
  void sleep(int count) { harness_->without_tick(count); }
  int until(const std::function<bool()>& so, int most) { return harness_->until(so, most); }
  int until(RunState state, int most) { return harness_->until(state, most); }

  [[nodiscard]] ProfilePosition progress() const { return harness_->progress(); }
  /// As the chamber itself has it, whatever anybody reads.
  [[nodiscard]] Celsius chambers_set_point() { return plant_->laboratory().set_point(); }
  /// Alarms that stand now, in words.
  [[nodiscard]] std::vector<std::string> standing() const { return harness_->run_controller().standing().faults_now; }

  /// Ends the program and reads what the record has.
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
