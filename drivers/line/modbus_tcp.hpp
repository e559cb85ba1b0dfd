/// Modbus TCP with every reply compared to its request, and the only place that calls libmodbus.
#pragma once

#include <memory>
#include <span>

#include "drivers/line/modbus.hpp"

namespace gyrotherm {

/// A connection that carries whole frames. In memory one that breaks on command.
class FrameConnection {
 public:
  virtual ~FrameConnection() = default;
  [[nodiscard]] virtual bool is_open() const = 0;
  /// Fails with disconnected.
  [[nodiscard]] virtual Result<void> open(Duration within) = 0;
  virtual void close() = 0;
  [[nodiscard]] virtual Result<void> send(std::span<const std::byte> frame) = 0;
  /// The next frame, unverified, into `frame`, which has room for 260 bytes; its size. Fails with timeout, corrupted or
  /// disconnected.
  [[nodiscard]] virtual Result<std::size_t> receive(std::span<std::byte> frame, Duration within) = 0;
  /// Waits; false as soon as something comes.
  [[nodiscard]] virtual bool silent_for(Duration time) = 0;
};

/// The guarded exchange over frames of its own: every field of a reply is compared with its request, the transaction
/// number above all, which counts on across connections. Any anomaly (no reply, a reply to something else, a broken
/// line) closes the connection, since what still comes on it may answer an older request; the next try opens a new one.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection,
                                                          std::string place, const ModbusLink& link,
                                                          const Clock* clock = nullptr);

/// The connection to a real unit, by libmodbus.
[[nodiscard]] std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line);

}  // namespace gyrotherm
