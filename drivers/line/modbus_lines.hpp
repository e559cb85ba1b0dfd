// SPDX-License-Identifier: Apache-2.0
/// Modbus TCP and RTU lines, which match every reply to its request. libmodbus is used only in the implementation.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

/// A connection that transfers complete frames. Tests use an in-memory connection that fails on command.
class FrameConnection {
 public:
  virtual ~FrameConnection() = default;
  [[nodiscard]] virtual bool is_open() const = 0;
  /// Connects within a time limit. Fails with disconnected.
  [[nodiscard]] virtual Result<void> open(Duration within) = 0;
  virtual void close() = 0;
  [[nodiscard]] virtual Result<void> send(std::span<const std::byte> frame) = 0;
  /// Reads the next frame into `frame`, which must have 260 bytes, and returns its size. Does not verify its fields.
  /// Fails with timeout, corrupted or disconnected.
  [[nodiscard]] virtual Result<std::size_t> receive(std::span<std::byte> frame, Duration within) = 0;
  /// Waits for `time` and returns true, or returns false as soon as a byte arrives.
  [[nodiscard]] virtual bool is_silent_for(Duration time) = 0;
};

/// Returns a Modbus TCP line. Every field of a reply is compared with its request, in particular the transaction
/// number, which continues counting across connections. After any anomaly (no reply, a wrong reply, a broken
/// connection) the connection is closed, because a late answer may still arrive on it; the next attempt opens a new
/// one.
///
/// If the link has `returns_other_transaction`, answers are distinguished by time, as in RTU. Only one exchange is in
/// progress at a time, and the connection must have no unread byte when it begins. After a failure, the new connection
/// must first be silent for a whole timeout, and at least until twice the timeout has passed since the request. The
/// ambiguities of make_modbus_rtu() then apply too.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection,
                                                          std::string place, const ModbusLink& link,
                                                          const Clock* clock = nullptr);

/// Returns a connection to a real unit, using libmodbus.
[[nodiscard]] std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line);

/// Returns a Modbus RTU line over a serial port, or over a gateway that forwards RTU frames over TCP. An RTU frame does
/// not identify its request, so answers are distinguished by time:
///
/// - Before a request, the line must be silent for the link's gap. Bytes that arrive in this time are discarded.
/// - A reply must have the request's unit, function and byte count (for a write: address and count or value), the
///   corresponding size, and a correct CRC. It is searched for in all bytes that arrive within the timeout, at most
///   768; bytes before and after it, from an idle bus or other units, are ignored.
/// - The request itself is not a reply. A line that echoes requests is refused, unless the link has `echo`, with which
///   the stream removes the echo. The reply to a write by function 5 or 6 equals its request. Therefore a read of the
///   same address must show that the line does not echo, unless another reply has shown it since the line was opened.
/// - After a request without such a reply, or after five or more unsolicited bytes (the size of the shortest reply),
/// the
///   next request waits until the line has been silent for a whole timeout and twice the timeout has passed since the
///   earlier request. An answer within twice the timeout has arrived by then and was discarded. With `loop_back`, the
///   unit must then also return a number that was never used before; because units answer in order, no older answer
///   can follow.
///
/// The following bytes are accepted as the answer although they are not:
///
/// - without `loop_back`, an answer that arrives later than twice the timeout, while an answer of the same form is
///   expected;
/// - a copy of an earlier answer, while an answer of the same form is expected;
/// - an answer of a second unit with the same number;
/// - the echo of a write by function 5 or 6, on a line that began to echo while it was open.
///
/// To protect against these cases, read back written values, compare values with other instruments, and choose a
/// timeout that suits the unit.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_rtu(std::unique_ptr<ByteStream> stream, std::string place,
                                                          const ModbusLink& link, const Clock* clock = nullptr);

/// Returns the silence between frames: the link's gap, or 3.5 characters; above 19200 baud, 1.75 ms instead of 3.5
/// characters (Modbus over Serial Line V1.02, section 2.5.1.1).
[[nodiscard]] Duration silence_between_frames(const ModbusLink& link);

}  // namespace gyrotherm::drivers
