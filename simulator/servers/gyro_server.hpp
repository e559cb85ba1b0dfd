// SPDX-License-Identifier: Apache-2.0
/// The line of a virtual gyro. It sends frames to all connected clients.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/gyro/frame_format.hpp"
#include "drivers/gyro/framed_gyro.hpp"
#include "simulator/servers/memory_line.hpp"
#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

/// Returns the format with a rate of one frame per second. In a dry run the virtual gyro and its driver use it.
[[nodiscard]] drivers::FrameFormat slow_to_one_frame_per_second(drivers::FrameFormat format);

/// Writes consecutive frames. Increments and rates are chosen so that the sum of all sent values, rounded as in the
/// frames, equals the angle: no rounding error accumulates between frames, whatever the resolution of the field. One
/// message carries all fields; streams that send their axes in several messages are not simulated.
class StreamWriter {
 public:
  /// Creates a writer. `arcsec_per_pulse` is the size of a pulse for each axis of the format. It is used for fields in
  /// a unit of angle.
  StreamWriter(drivers::FrameFormat format, std::vector<double> arcsec_per_pulse);

  /// Returns the bytes that precede the first frame on a newly opened line: an end of line, or as many frames without
  /// motion as the reader needs to lock.
  [[nodiscard]] std::vector<std::byte> lead_in() const;
  /// Returns the next frame. `pulses` is the count of each axis (fractions occur within a second) and `device_time_us`
  /// the gyro's clock, both since the start; `seconds` is the time since the last frame. `values` is the housekeeping
  /// in the order of list_housekeeping(), without the last two entries. A missing or non-finite value is sent as 25 °C
  /// for a temperature and as 0 otherwise.
  [[nodiscard]] std::vector<std::byte> next(std::span<const double> pulses, std::int64_t device_time_us, double seconds,
                                            std::span<const double> values = {});
  /// Multiplies increments and rates of later frames by `factor`, as if the device were configured to another unit of
  /// measure.
  void set_factor(double factor) { factor_ = factor; }
  [[nodiscard]] const drivers::FrameFormat& format() const { return format_; }
  /// Skips a frame. The next increments start from `pulses`.
  void skip(std::span<const double> pulses);

 private:
  /// One axis and the sum of its sent values.
  struct Axis {
    drivers::FrameField field;
    double arcsec_per_pulse{};
    /// Size of the field's unit of angle; 0 for plain pulses.
    double arcsec_per_unit{};
    /// Sum of all sent increments: integer counts, or for real numbers and rates an angle in the field's unit.
    std::int64_t counts{};
    double angle{};
  };
  [[nodiscard]] std::uint32_t sequence(std::int64_t number) const;
  [[nodiscard]] drivers::GyroFrame frame(std::int64_t number, std::int64_t device_time_us) const;
  [[nodiscard]] static drivers::AxisReading put_counts(double pulses, Axis& axis);
  [[nodiscard]] static drivers::AxisReading put_angle(double pulses, double seconds, Axis& axis);

  drivers::FrameFormat format_;
  std::vector<Axis> axes_;
  /// Default values of the housekeeping fields that the caller does not set.
  std::vector<double> default_values_;
  /// Number of the next frame.
  std::int64_t number_{};
  double factor_ = 1;
};

/// Faults of a virtual gyro whose configuration differs from its description. Commands are identified by their first
/// line.
struct GyroUnitFaults {
  /// First lines of commands. The unit neither executes nor answers a command in `ignored`, and answers one in
  /// `refused` with a refusal.
  std::vector<std::string> ignored{};
  std::vector<std::string> refused{};
  /// Factor of increments and rates until the command `factor_until` is executed.
  double factor = 1;
  std::string factor_until{};
  /// True if the configuration message reports settings that differ from the description.
  bool has_other_settings{};
};

/// Serves the gyro's line without a thread. send() accepts the waiting clients on the thread that advances the time, so
/// no client misses a frame. From clients the server accepts only the commands of the stream's description that require
/// an answer. While a command has silenced the stream no frame is sent. A client that has closed or does not accept its
/// frames is dropped.
class GyroServer {
 public:
  static constexpr std::size_t kMaxClients = 16;

  /// Creates a server. `commands` are those that start the stream, with their replies. A closed listener accepts no
  /// clients.
  GyroServer(Descriptor listener, StreamWriter writer, std::vector<drivers::GyroCommand> commands = {},
             GyroUnitFaults faults = {});
  void add(Pty line);
  /// Returns a new connection for a client in this process.
  [[nodiscard]] std::shared_ptr<MemoryConnection> connect();

  /// Switches the unit's power. Without power, it answers no command. At power-on it sends frames.
  void set_powered(bool on);
  /// Accepts clients and answers their commands.
  void serve_clients();
  /// Sends one frame (StreamWriter::next).
  void send(std::span<const double> pulses, std::int64_t device_time_us, double seconds = 1,
            std::span<const double> values = {});
  /// Skips a frame without sending it.
  void skip(std::span<const double> pulses) { writer_.skip(pulses); }

 private:
  struct Client {
    Descriptor socket;
    std::string received{};
  };
  struct Line {
    Pty pty;
    std::string received{};
  };
  /// A client in this process.
  struct LocalClient {
    std::shared_ptr<MemoryConnection> connection;
    std::string received{};
  };
  void admit(Descriptor client);
  [[nodiscard]] std::string replies(std::span<const char> bytes, std::string& received);
  [[nodiscard]] std::string replies(int descriptor, std::string& received);
  [[nodiscard]] std::string execute(const drivers::GyroCommand& command);
  static void send_to(LocalClient& client, std::span<const std::byte> bytes);

  Descriptor listener_;
  StreamWriter writer_;
  /// Only commands that require an answer.
  std::vector<drivers::GyroCommand> commands_;
  GyroUnitFaults faults_;
  /// Set while a command keeps the stream silent.
  bool is_silent_{};
  bool is_powered_ = true;
  std::vector<Client> clients_;
  std::vector<Line> lines_;
  std::vector<LocalClient> local_clients_;
};

}  // namespace gyrotherm::simulator
