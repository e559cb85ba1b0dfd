/// Modbus TCP with every reply compared to its request: the guarded exchange, and the only place that calls libmodbus.
#pragma once

#include <cstdint>
#include <memory>

#include "drivers/wires.hpp"

namespace gyrotherm {

/// Registers of `unit` behind `address`. Connects at first use. `timeout` is how long one try waits for its reply.
///
/// A read has up to three tries within one limit of 1.0 s. Any anomaly (no reply, a reply to something else, a broken
/// line) closes the connection, since what still comes on it may answer an older request; the next try opens a new one.
/// A unit that says it is busy is asked again within the limit. A write has one try: if it fails, whether it was
/// carried out is unknown until the register is read. After a second failure in a row the line rests 0.5 s, then
/// longer, up to 10 s; until then every use fails at once.
[[nodiscard]] std::unique_ptr<Registers> make_modbus_tcp(const LineAddress& address, std::uint8_t unit,
                                                         Duration timeout);

}  // namespace gyrotherm
