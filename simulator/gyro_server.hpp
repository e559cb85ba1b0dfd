/// The virtual gyro's line: one frame a second to whoever is connected.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/gyro/frame_format.hpp"
#include "simulator/sockets.hpp"

namespace gyrotherm {

/// Needs no thread: clients that have connected by then are let in by send(), on the thread that lets time pass, so
/// that none misses a second. What clients send is never read. A client that is gone or does not take its frames is
/// dropped.
class GyroServer {
 public:
  static constexpr std::size_t kMostClients = 16;

  GyroServer(Socket listener, FrameFormat format);

  /// One frame: pulses and device time since the start; they go out as the format wants them.
  void send(std::int64_t pulses, std::int64_t device_time_us);
  /// Lets a second pass without a frame: the next increment counts from here.
  void skip(std::int64_t pulses) {
    sent_pulses_ = pulses;
    ++sequence_;
  }

 private:
  [[nodiscard]] std::vector<std::byte> frame(std::int64_t pulses, std::int64_t device_time_us) const;
  void admit_all();

  Socket listener_;
  FrameFormat format_;
  std::vector<Socket> clients_;
  std::uint32_t sequence_{};
  std::int64_t sent_pulses_{};
};

}  // namespace gyrotherm
