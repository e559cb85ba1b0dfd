// SPDX-License-Identifier: Apache-2.0
/// Modbus TCP and RTU lines that match every reply to its request. Only this implementation uses libmodbus.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/file.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

/// A connection that carries whole frames. Tests use one in memory that fails on command.
class FrameConnection {
 public:
  virtual ~FrameConnection() = default;
  [[nodiscard]] virtual bool is_open() const = 0;
  /// Fails with disconnected.
  [[nodiscard]] virtual Result<void> open(Duration within) = 0;
  virtual void close() = 0;
  [[nodiscard]] virtual Result<void> send(std::span<const std::byte> frame) = 0;
  /// Reads the next frame, unverified, into `frame`, which must have 260 bytes; returns its size. Fails with timeout,
  /// corrupted or disconnected.
  [[nodiscard]] virtual Result<std::size_t> receive(std::span<std::byte> frame, Duration within) = 0;
  /// Waits for `time` and returns true, or returns false as soon as a byte arrives.
  [[nodiscard]] virtual bool silent_for(Duration time) = 0;
};

/// Returns a Modbus TCP line. Every field of a reply is compared with its request, in particular the transaction
/// number, which continues counting across connections. After any anomaly (no reply, a wrong reply, a broken
/// connection) the connection is closed, because a late answer may still arrive on it; the next attempt opens a new
/// one.
///
/// If the link has `returns_other_transaction`, answers are distinguished by time, as in RTU. Only one exchange is in
/// progress at a time, and no unread byte may be on the connection when it begins. After a failure, the new connection
/// must first be silent for a whole timeout, and at least until twice the timeout has passed since the request. The
/// ambiguities of RTU frames (below) then apply too.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection,
                                                          std::string place, const ModbusLink& link,
                                                          const Clock* clock = nullptr);

/// Returns a connection to a real unit, using libmodbus.
[[nodiscard]] std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line);
/// Returns a connected, non-blocking socket.
using Connect = std::function<Result<Descriptor>()>;
/// Returns a connection over the socket that `connect` provides.
[[nodiscard]] std::unique_ptr<FrameConnection> make_modbus_connection(Connect connect);

/// Returns a Modbus RTU line over a serial port, or over a gateway that forwards RTU frames over TCP. An RTU frame does
/// not identify its request, so time separates answers:
///
/// - Before a request, the line must be silent for the link's gap. Bytes that arrive in this time are discarded.
/// - A reply must have the request's unit, function and byte count (for a write: address and count or value), the
///   corresponding size, and a correct CRC. All bytes that arrive within the timeout, at most 768, are searched for it;
///   an idle bus and other units add bytes before and after it, which are ignored.
/// - The request itself is not a reply. A line that echoes it is refused, unless `echo` makes the stream read the echo.
///   The reply to a write by function 5 or 6 equals its request. Therefore a read of the same address must prove that
///   the line does not echo, unless another reply has proved it since the line was opened.
/// - After a request without such a reply, or after five or more unsolicited bytes (the shortest reply), the next
///   request waits until the line was silent for a whole timeout and twice the timeout has passed since the request. A
///   unit that answers within twice its timeout has answered by then, and its bytes were discarded. With `loop_back`,
///   the unit must then also return a number that was never used before; because units answer in order, no older answer
///   can follow.
///
/// These cases cannot be distinguished: without loop_back, an answer that arrives later than twice the timeout while an
/// answer of the same form is expected; a copy of an earlier answer of the same form that arrives while the next answer
/// is expected; an answer of a second unit with the same number; the echo of a write by function 5 or 6 on a line that
/// began to echo while it was open. To protect against them, read back written values, compare values with other
/// instruments, and choose a timeout that suits the unit.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_rtu(std::unique_ptr<ByteStream> stream, std::string place,
                                                          const ModbusLink& link, const Clock* clock = nullptr);

/// Returns the silence between frames: the link's gap, or 3.5 characters, which count as 1.75 ms from 19200 baud
/// (Modbus over Serial Line V1.02, section 2.5.1.1).
[[nodiscard]] Duration silence_between_frames(const ModbusLink& link);

}  // namespace gyrotherm::drivers
