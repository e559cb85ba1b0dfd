// SPDX-License-Identifier: Apache-2.0
/// The virtual gyro's line: frames to whoever is connected.
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

/// A format at one frame a second: what the virtual gyro sends in a dry run, and what its driver then expects.
[[nodiscard]] drivers::FrameFormat at_one_frame_a_second(drivers::FrameFormat format);

/// Writes one frame after the other. Increments and rates are what brings the sum of all that has been sent, rounded as
/// the frames round it, to the angle: nothing is lost between frames, whatever the field's resolution. One message
/// carries all that is written: a stream that brings its axes in several is not simulated.
class StreamWriter {
 public:
  /// `arcsec_per_pulse`: what a pulse of the world is, of each of the format's axes, for fields in an angle's unit.
  StreamWriter(drivers::FrameFormat format, std::vector<double> arcsec_per_pulse);

  /// What has come before the stream's first frame on a line that has just been opened: an end of line, or as many
  /// frames without motion as must fit before one is believed.
  [[nodiscard]] std::vector<std::byte> lead_in() const;
  /// The next frame, where `pulses` have been counted by each axis and the gyro's clock is at `device_time_us`, both
  /// since the start (fractions of a pulse lie within frames), and `seconds` have passed since the last frame.
  /// `values`: the housekeeping in the order of housekeeping_of(), without its last two; what is missing there, or is
  /// no number, is 25 °C of a temperature and 0 of anything else.
  [[nodiscard]] std::vector<std::byte> next(std::span<const double> pulses, std::int64_t device_time_us, double seconds,
                                            std::span<const double> values = {});
  /// Makes increments and rates of later frames this multiple of the true ones: a unit that is set to another unit of
  /// measure.
  void set_factor(double factor) { factor_ = factor; }
  [[nodiscard]] const drivers::FrameFormat& format() const { return format_; }
  /// The same, but the frame goes to nobody: increments count from here.
  void skip(std::span<const double> pulses);

 private:
  /// One axis, and what has been sent of it.
  struct Axis {
    drivers::FrameField field;
    double arcsec_per_pulse{};
    double arcsec_per_unit{};  ///< of the field's angle; 0 for plain pulses
    std::int64_t counts{};     ///< sum of all increments
    double angle{};            ///< the same of real numbers and rates, in the field's unit of angle
  };
  [[nodiscard]] std::uint32_t sequence(std::int64_t number) const;
  [[nodiscard]] drivers::GyroFrame frame(std::int64_t number, std::int64_t device_time_us) const;
  [[nodiscard]] static drivers::AxisReading put_counts(double pulses, Axis& axis);
  [[nodiscard]] static drivers::AxisReading put_angle(double pulses, double seconds, Axis& axis);

  drivers::FrameFormat format_;
  std::vector<Axis> axes_;
  std::vector<double> usual_;  ///< the housekeeping where nothing is said
  std::int64_t number_{};      ///< of the next frame
  double factor_ = 1;
};

/// Faults of a virtual gyro that is set otherwise than its description. Commands are named by their first line.
struct GyroUnitFaults {
  std::vector<std::string> ignored{};  ///< commands without effect and answer
  std::vector<std::string> refused{};  ///< commands answered with their refusal
  /// Increments and rates are this multiple until `factor_until` is obeyed.
  double factor = 1;
  std::string factor_until{};
  bool has_other_settings{};  ///< shown by its configuration message
};

/// Needs no thread: clients that have connected by then are let in by send(), on the thread that lets time pass, so
/// that none misses a frame. Of what clients send nothing is understood but the commands of the stream's description
/// that require an answer. In a silence that a command ordered no frame is sent. A client that is gone or does not take
/// its frames is dropped.
class GyroServer {
 public:
  static constexpr std::size_t kMostClients = 16;

  /// `commands`: what starts the stream, and the replies. A listener that is closed lets nobody in.
  GyroServer(Descriptor listener, StreamWriter writer, std::vector<drivers::GyroCommand> commands = {},
             GyroUnitFaults faults = {});
  void add(Pty line);
  /// A new connection of the client in this process.
  [[nodiscard]] std::shared_ptr<MemoryConnection> connect();

  /// Lets clients in, and answers their commands.
  void attend();
  /// One frame, as StreamWriter::next makes it.
  void send(std::span<const double> pulses, std::int64_t device_time_us, double seconds = 1,
            std::span<const double> values = {});
  /// Lets a frame pass with nobody listening.
  void skip(std::span<const double> pulses) { writer_.skip(pulses); }

 private:
  struct Client {
    Descriptor socket;
    std::string heard{};
  };
  struct Line {
    Pty pty;
    std::string heard{};
  };
  /// The client that is attended in this process.
  struct Near {
    std::shared_ptr<MemoryConnection> connection;
    std::string heard{};
  };
  void admit(Descriptor client);
  [[nodiscard]] std::string replies(std::span<const char> bytes, std::string& heard);
  [[nodiscard]] std::string replies(int descriptor, std::string& heard);
  [[nodiscard]] std::string obey(const drivers::GyroCommand& command);
  static void give(Near& client, std::span<const std::byte> bytes);

  Descriptor listener_;
  StreamWriter writer_;
  std::vector<drivers::GyroCommand> commands_;  ///< all require an answer
  GyroUnitFaults faults_;
  bool is_silent_{};  ///< ordered by a command
  std::vector<Client> clients_;
  std::vector<Line> lines_;
  std::vector<Near> near_;
};

}  // namespace gyrotherm::simulator
