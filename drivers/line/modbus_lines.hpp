// SPDX-License-Identifier: Apache-2.0
/// Modbus TCP with every reply compared to its request, and the only place that calls libmodbus.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/file.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

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
///
/// If the link has `returns_other_transaction`, time keeps answers apart as on RTU: one exchange at a time, nothing may
/// wait on the connection, and the fresh connection after a failure must first be silent for a whole timeout, and until
/// twice the timeout has passed since the request. It then has the limits of RTU frames (below).
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_tcp(std::unique_ptr<FrameConnection> connection,
                                                          std::string place, const ModbusLink& link,
                                                          const Clock* clock = nullptr);

/// The connection to a real unit, by libmodbus.
[[nodiscard]] std::unique_ptr<FrameConnection> make_modbus_connection(const TcpLine& line);
/// Makes a connection, which does not block.
using Connect = std::function<Result<Descriptor>()>;
/// … over one that somebody else makes.
[[nodiscard]] std::unique_ptr<FrameConnection> make_modbus_connection(Connect connect);

// Modbus RTU on a line that carries bytes: a serial port, or a gateway that passes RTU frames on over TCP.

/// The guarded exchange of RTU frames. A frame holds no number of its request, so time keeps answers apart:
///
/// - Before a request the line must be silent for the link's gap. Whatever comes in that silence is thrown away.
/// - A reply must have the request's unit, function and byte count (a write: address and count or value), the size that
///   follows from them, and a CRC that fits. It is searched for among all bytes that come within the timeout, at most
///   768: an idle bus and other units put bytes before it and behind it, which count nothing.
/// - The request itself does not count as a reply. A line that returns it is refused, unless `echo` has the stream read
/// it back. The
///   reply to a write by 5 or 6 equals its request: where no other reply since the opening has shown that the line does
///   not echo, a read of the same address must show it.
/// - After a request that got no such reply, and after five unsolicited bytes or more (the shortest reply),
///   the next request waits until the line has been silent for a whole timeout, and until twice the timeout has passed
///   since the request. A unit that answers within twice its timeout has then answered, and what it sent was thrown
///   away. With `loop_back` the unit must then also return a number that was never used before, and since units answer
///   in turn, nothing older can follow.
///
/// What cannot be told apart: without loop_back, an answer that comes later than twice the timeout, while an answer of
/// the same shape is awaited; a copy of an earlier answer of that shape that comes while the next is awaited; an answer
/// of a second unit with the same number; the echo of a write by 5 or 6 on a line that began to echo while it was open.
/// Reading back what was written and comparing values with other instruments guard these, and a timeout that suits the
/// unit.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_rtu(std::unique_ptr<ByteStream> stream, std::string place,
                                                          const ModbusLink& link, const Clock* clock = nullptr);

/// The silence between frames: the link's gap, or 3.5 characters, which from 19200 baud on count as 1.75 ms (Modbus
/// over Serial Line V1.02, section 2.5.1.1).
[[nodiscard]] Duration silence_between_frames(const ModbusLink& link);

}  // namespace gyrotherm::drivers
