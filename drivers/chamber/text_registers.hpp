// SPDX-License-Identifier: Apache-2.0
/// The client of a text unit, as registers: a read sends the question of an item, a write its command.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/clock.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Returns the registers of a text unit on an open or unopened stream. `map` must have a text link. `clock` is the
/// clock of the stream and must outlive the registers; null means the steady clock.
/// A failed exchange has the fault of TextClient::ask().
[[nodiscard]] std::unique_ptr<Registers> make_text_registers(const RegisterMap& map, std::unique_ptr<ByteStream> stream,
                                                             std::string place, const Clock* clock = nullptr);

/// Returns whether the unit answered in a form without the field of this item, such as "NONE" instead of a set point.
/// As a number, such words are NaN. Returns false for a Modbus unit.
[[nodiscard]] bool has_no_value(const RegisterMap& map, const RegisterItem& item, std::span<const std::uint16_t> words);

/// Returns the stream of a text unit at the end of `line`, which must satisfy is_byte_line(), with the defaults of the
/// map's selected link.
[[nodiscard]] std::unique_ptr<ByteStream> make_text_stream(const Line& line, const RegisterMap& map);

/// Returns the registers of a Modbus or text unit at the end of `line`, which must satisfy is_byte_line(). The line is
/// opened at first use.
[[nodiscard]] std::unique_ptr<Registers> make_registers(const Line& line, const RegisterMap& map);

}  // namespace gyrotherm::drivers
