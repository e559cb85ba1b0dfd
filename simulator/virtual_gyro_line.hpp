// SPDX-License-Identifier: Apache-2.0
/// A gyro line of the virtual rig: the axes of one unit under test, or of several behind one serial device, as frames
/// that fall due at the line's own pace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// At how many frames a second a gyro sends.
enum class FramePace {
  one_a_second,  ///< of every stream
  full_rate,     ///< the stream's own, where it has one
};

/// What is on the line. A unit's values come in the fields that have their names, or "UNIT_NAME"; a name by itself is
/// the first unit's, and so is its own temperature in a field for a temperature of any other name.
struct VirtualGyroLine {
  /// An axis of the world; one without a name may be called by any.
  struct Axis {
    std::string unit, axis;
  };
  drivers::FrameFormat frame;
  std::vector<drivers::GyroCommand> commands{};  ///< that start its stream: those with a reply are answered
  std::vector<Axis> axes{};  ///< in the order of the frame's; none: those of the world's only unit, in its order
};

/// The axes of a line in the world, and which of its values are in the frame.
struct GyroLineSources {
  struct Axis {
    std::size_t unit{}, axis{};
  };
  struct Value {
    std::size_t unit{}, value{};
  };
  std::vector<Axis> axes;
  std::vector<std::optional<Value>> values;  ///< in the order of FrameFormat::values()
  std::vector<std::size_t> units;            ///< each once
};

/// Fails with usage if an axis is none of the world's, or the frame has another number of them.
[[nodiscard]] Result<GyroLineSources> sources_of(const VirtualGyroLine& line, const VirtualLaboratory& laboratory);

class PacedGyroLine {
 public:
  /// `sources`: of this line.
  PacedGyroLine(VirtualGyroLine line, GyroLineSources sources, FramePace pace, double arcsec_per_pulse,
                Descriptor listener);

  void add(Pty pty) { server_.add(std::move(pty)); }
  [[nodiscard]] std::shared_ptr<MemoryConnection> connect() { return server_.connect(); }
  void attend() { server_.attend(); }
  /// When the next frame is due, seconds since the start.
  [[nodiscard]] double next_s() const { return static_cast<double>(frames_ + 1) / frames_a_second_; }
  /// A second begins; has passed.
  void begin_second(const VirtualLaboratory& laboratory) { before_ = stand(laboratory); }
  void end_second(const VirtualLaboratory& laboratory) { after_ = stand(laboratory); }
  /// Sends the next frame, `share` of the second after its beginning. Of a line whose units all are silent the frame is
  /// lost; of one of several the counts stand still, and what it counts meanwhile is lost. Without power there is none.
  void send(const VirtualLaboratory& laboratory, double share);
  /// Lets a frame at the end of a second pass with nobody listening.
  void skip(const VirtualLaboratory& laboratory);

 private:
  /// Where the axes stand at the ends of the second under way.
  struct Stand {
    std::vector<std::int64_t> pulses{};
    std::int64_t device_time_us{};
  };
  [[nodiscard]] Stand stand(const VirtualLaboratory& laboratory) const;
  void count(const VirtualLaboratory& laboratory, double share);
  [[nodiscard]] bool is_silent(const VirtualLaboratory& laboratory) const;
  void gather_values(const VirtualLaboratory& laboratory);

  GyroLineSources sources_;
  GyroServer server_;
  double frames_a_second_;
  std::int64_t frames_{};
  Stand before_, after_;
  std::vector<double> sent_, lost_;  ///< pulses of each axis
  std::vector<double> values_;
};

}  // namespace gyrotherm::simulator
