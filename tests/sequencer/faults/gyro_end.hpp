// SPDX-License-Identifier: Apache-2.0
/// The gyro's end of its line. Sends one frame per second, intact or damaged.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "sequencer/rig/rig_file.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "tests/sequencer/faults/memory_line.hpp"

namespace gyrotherm::faults {

/// Faults of the gyro's frames, in addition to the faults of its line.
struct GyroTrouble {
  /// Shares of the frames that are garbled or lost.
  double garbled{}, lost{};
  /// Frames wait, and arrive together when the fault is over.
  bool held_back{};
  bool dead{};  ///< its counters stop
};

class GyroEnd {
 public:
  /// The laboratory must outlive this object. `settings` are those of the line.
  GyroEnd(const rig::GyroLine& settings, const std::vector<rig::UnitSettings>& units,
          const simulator::VirtualLaboratory& laboratory, const Clock& rig, std::uint64_t seed);

  GyroTrouble trouble;

  void send_frame();
  /// Restarts the gyro with its counters at zero.
  void restart();
  [[nodiscard]] LineEnd& line() { return line_; }
  /// Returns true if `count` equals the difference between two received frames over the same interval. Compares the
  /// axes from index `first` on.
  [[nodiscard]] bool matches_sent_counts(const GyroCount& count, std::size_t first) const;

 private:
  /// A frame that the program received whole.
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
  /// The frame at which the counters were zero.
  Sent origin_;
  Sent before_;  ///< the previous second
  Bytes held_back_;
  std::vector<Sent> held_frames_;
  /// The last received frames.
  std::deque<Sent> frames_;
};

}  // namespace gyrotherm::faults
