// SPDX-License-Identifier: Apache-2.0
/// A gyro's end of its line: it sends a frame a second, whole or not.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "sequencer/rig/rig_file.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "tests/sequencer/faults/memory_line.hpp"

namespace gyrotherm::faults {

/// What can be wrong with the gyro's frames, beside its line.
struct GyroTrouble {
  double garbled{}, lost{};  ///< shares of the frames
  bool held_back{};          ///< frames wait, and come all at once when this is over
  bool dead{};               ///< its counters stand still
};

class GyroEnd {
 public:
  /// The laboratory outlives it; `settings` are those of the line.
  GyroEnd(const rig::GyroLine& settings, const std::vector<rig::UnitSettings>& units,
          const simulator::VirtualLaboratory& laboratory, const Clock& rig, std::uint64_t seed);

  GyroTrouble trouble;

  void send_frame();
  /// Starts again: its counters at zero.
  void restart();
  [[nodiscard]] LineEnd& line() { return line_; }
  /// Whether those counts over that interval are what two frames that came say, of the axes from `first` on.
  [[nodiscard]] bool was_counted(const GyroCount& count, std::size_t first) const;

 private:
  /// One frame that came to the program whole.
  struct Sent {
    std::vector<std::int64_t> pulses;
    std::int64_t device_time_us{};
  };
  struct Axis {
    std::size_t unit{}, axis{};  ///< in the laboratory
  };
  [[nodiscard]] Sent now() const;
  [[nodiscard]] simulator::StreamWriter make_writer() const;

  const simulator::VirtualLaboratory& laboratory_;
  std::vector<Axis> axes_;
  drivers::FrameFormat format_;
  simulator::StreamWriter writer_;
  LineEnd line_;
  Sent origin_;  ///< where its counters were at zero
  Sent before_;  ///< a second ago
  Bytes held_back_;
  std::vector<Sent> held_frames_;
  std::deque<Sent> frames_;  ///< the last ones that came
};

}  // namespace gyrotherm::faults
