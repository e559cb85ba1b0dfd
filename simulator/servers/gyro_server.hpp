/// The virtual gyro's line: frames to whoever is connected.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/gyro/frame_stream.hpp"
#include "simulator/servers/sockets.hpp"
#include "simulator/servers/stream_writer.hpp"

namespace gyrotherm {

/// Needs no thread: clients that have connected by then are let in by send(), on the thread that lets time pass, so
/// that none misses a frame. Of what clients send nothing is understood but the commands of the stream's description
/// that have a reply. A client that is gone or does not take its frames is dropped.
class GyroServer {
 public:
  static constexpr std::size_t kMostClients = 16;

  /// `commands`: what starts the stream, and the replies.
  GyroServer(Descriptor listener, StreamWriter writer, std::vector<GyroCommand> commands = {});
  void add(Pty line);

  /// Lets clients in, and answers their commands.
  void attend();
  /// One frame, as StreamWriter::next makes it.
  void send(double pulses, std::int64_t device_time_us, double seconds = 1);
  /// Lets a frame pass with nobody listening.
  void skip(double pulses) { writer_.skip(pulses); }

 private:
  struct Client {
    Descriptor socket;
    std::string heard{};
  };
  struct Line {
    Pty pty;
    std::string heard{};
  };
  [[nodiscard]] std::string replies(int descriptor, std::string& heard) const;

  Descriptor listener_;
  StreamWriter writer_;
  std::vector<GyroCommand> commands_;  ///< with a reply
  std::vector<Client> clients_;
  std::vector<Line> lines_;
};

}  // namespace gyrotherm
