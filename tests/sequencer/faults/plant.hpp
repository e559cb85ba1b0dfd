// SPDX-License-Identifier: Apache-2.0
/// The virtual laboratory as it stands beside the program: it goes on while no program runs, and breaks on command.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "rig/rig_file.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/laboratory_file.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "tests/sequencer/faults/chamber_port.hpp"
#include "tests/sequencer/faults/memory_line.hpp"

namespace gyrotherm::faults {

/// What can be wrong with the gyro's frames, beside its line.
struct GyroTrouble {
  double garbled{}, lost{};  ///< shares of the frames
  bool held_back{};          ///< frames wait, and come all at once when this is over
};

/// One frame that came to the program whole.
struct GyroFrameSent {
  std::int64_t pulses{}, device_time_us{};
};

class Plant {
 public:
  Plant(const rig::RigFile& file, const simulator::LaboratoryParameters& parameters, const Clock& rig,
        std::uint64_t seed);
  Plant(const Plant&) = delete;

  simulator::LaboratoryFaults faults;  ///< in force after the next apply_faults()
  GyroTrouble gyro_trouble;
  void apply_faults() { laboratory_.inject(faults); }

  /// Lets one second pass, and the gyro send its frame.
  void pass_second();
  /// The gyro starts again: its counters at zero.
  void restart_gyro();
  /// The controller starts again, at `set_point` and conditioning or not.
  void restart_chamber(Celsius set_point, bool on);
  /// Of an item of the chamber's map, by somebody at its panel.
  void write(const char* item, double value);

  [[nodiscard]] simulator::VirtualLaboratory& laboratory() { return laboratory_; }
  [[nodiscard]] ChamberPort& chamber() { return chamber_port_; }
  [[nodiscard]] std::size_t thermometer_count() const { return thermometers_.size(); }
  [[nodiscard]] LineEnd& thermometer(std::size_t index) { return *thermometers_[index]; }
  [[nodiscard]] LineEnd& gyro() { return gyro_line_; }

  /// Whether those counts over that interval are what two frames that came say.
  [[nodiscard]] bool was_counted(const PulseCount& count) const;

 private:
  void send_frame();

  simulator::VirtualLaboratory laboratory_;
  simulator::ChamberRegisters registers_;
  ChamberPort chamber_port_;
  std::vector<std::unique_ptr<simulator::Session>> sessions_;
  std::vector<std::unique_ptr<LineEnd>> thermometers_;
  drivers::FrameFormat frame_format_;
  simulator::StreamWriter writer_;
  LineEnd gyro_line_;
  GyroFrameSent gyro_origin_;  ///< where the gyro's counters were at zero
  Bytes held_back_;
  std::vector<GyroFrameSent> held_frames_;
  std::deque<GyroFrameSent> frames_;  ///< the last ones that came
};

}  // namespace gyrotherm::faults
