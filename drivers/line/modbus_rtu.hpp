/// Modbus RTU on a line that carries bytes: a serial port, or a gateway that passes RTU frames on over TCP.
#pragma once

#include <memory>
#include <string>

#include "drivers/line/modbus.hpp"

namespace gyrotherm {

/// The guarded exchange of RTU frames. A frame holds no number of its request, so time keeps answers apart:
///
/// - Before a request the line must be silent for the link's gap. Whatever comes in that silence is thrown away.
/// - A reply must have the request's unit, function and byte count (a write: address and count or value), the size that
///   follows from them, a CRC that fits, and nothing behind it.
/// - After a request that got no such reply, and after bytes that nobody asked for, the next request waits until the
///   line has been silent for a whole timeout, and until twice the timeout has passed since the request. A unit that
///   answers within twice its timeout has then answered, and what it sent was thrown away. With `loop_back` the unit
///   must then also return a number that was never used before, and since units answer in turn, nothing older can
///   follow.
///
/// What cannot be told apart: without loop_back, an answer that comes later than twice the timeout, while an answer of
/// the same shape is awaited; a copy of an earlier answer of that shape that comes while the next is awaited; an answer
/// of a second unit with the same number; the echo of a write by a line that returns what is sent. Reading back what
/// was written and comparing values with other instruments guard these, and a timeout that suits the unit.
[[nodiscard]] std::unique_ptr<ModbusLine> make_modbus_rtu(std::unique_ptr<ByteStream> stream, std::string place,
                                                          const ModbusLink& link, const Clock* clock = nullptr);

/// The silence between frames: the link's gap, or 3.5 characters, which from 19200 baud on count as 1.75 ms (Modbus
/// over Serial Line V1.02, section 2.5.1.1).
[[nodiscard]] Duration silence_between_frames(const ModbusLink& link);

}  // namespace gyrotherm
