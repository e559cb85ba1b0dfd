// SPDX-License-Identifier: Apache-2.0
/// A gyro line of the virtual rig: the axes of one unit under test, or of several units behind one serial device, as
/// frames with their own schedule.
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

/// Frame rate of the gyro lines.
enum class FramePace {
  /// Every stream sends one frame.
  one_a_second,
  /// Each stream sends at its own rate if it has one.
  full_rate,
};

/// The content of a line. A value is sent in the field "UNIT_NAME", where NAME is the name of the value, or for the
/// first unit also in the field "NAME". A temperature field with any other name contains the first unit's own
/// temperature.
struct VirtualGyroLine {
  /// An axis of the laboratory. An axis without a name matches any name.
  struct Axis {
    std::string unit, axis;
  };
  drivers::FrameFormat frame;
  /// Commands that start the stream. Those with a reply are answered.
  std::vector<drivers::GyroCommand> commands{};
  /// The query for the identity, which only a marked instrument answers (mark_identities()).
  std::optional<drivers::IdentityQuery> identity{};
  /// Axes in the order of the frame. If empty, the line has all axes of the laboratory's only unit.
  std::vector<Axis> axes{};
};

/// Indices of a line's axes in the laboratory, and of the values that its frame contains.
struct GyroLineSources {
  struct Axis {
    std::size_t unit{}, axis{};
  };
  struct Value {
    std::size_t unit{}, value{};
  };
  std::vector<Axis> axes;
  /// In the order of FrameFormat::values().
  std::vector<std::optional<Value>> values;
  /// Units of the line without duplicates.
  std::vector<std::size_t> units;
};

/// Finds the sources of a line. Fails with usage if an axis is not in the laboratory, or if the frame has another
/// number of axes.
[[nodiscard]] Result<GyroLineSources> find_sources(const VirtualGyroLine& line, const VirtualLaboratory& laboratory);

class PacedGyroLine {
 public:
  /// Creates the line. `sources` must be the result of find_sources() for it.
  PacedGyroLine(VirtualGyroLine line, GyroLineSources sources, FramePace pace, double arcsec_per_pulse,
                Descriptor listener);

  void add(Pty pty) { server_.add(std::move(pty)); }
  [[nodiscard]] std::shared_ptr<MemoryConnection> connect() { return server_.connect(); }
  void serve_clients() { server_.serve_clients(); }
  /// Returns the time at which the next frame is due, in seconds since the start.
  [[nodiscard]] double next_s() const { return static_cast<double>(frames_ + 1) / frames_a_second_; }
  /// Stores the counts at the beginning or at the end of a second.
  void begin_second(const VirtualLaboratory& laboratory) { before_ = read_counts(laboratory); }
  void end_second(const VirtualLaboratory& laboratory) { after_ = read_counts(laboratory); }
  /// Sends the next frame at fraction `share` of the second. If all units of the line are silent, the frame is lost. If
  /// only some units are silent, their counts do not change and the pulses of that time are lost. Nothing is sent while
  /// the units have no power.
  void send(const VirtualLaboratory& laboratory, double share);
  /// Skips a frame at the end of a second; nothing is sent.
  void skip(const VirtualLaboratory& laboratory);

 private:
  /// Pulse counts and clock of the axes at the beginning or end of the current second.
  struct AxisCounts {
    std::vector<std::int64_t> pulses{};
    std::int64_t device_time_us{};
  };
  [[nodiscard]] AxisCounts read_counts(const VirtualLaboratory& laboratory) const;
  void count(const VirtualLaboratory& laboratory, double share);
  [[nodiscard]] bool is_silent(const VirtualLaboratory& laboratory) const;
  void gather_values(const VirtualLaboratory& laboratory);

  GyroLineSources sources_;
  GyroServer server_;
  double frames_a_second_;
  std::int64_t frames_{};
  AxisCounts before_, after_;
  /// Pulses of each axis.
  std::vector<double> sent_, lost_;
  std::vector<double> values_;
};

}  // namespace gyrotherm::simulator
