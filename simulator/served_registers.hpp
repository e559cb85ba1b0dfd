// SPDX-License-Identifier: Apache-2.0
/// The interface between the registers of a virtual Modbus unit and the server of its line.
#pragma once

#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::simulator {

/// Codes of a Modbus exception reply (Modbus Application Protocol V1.1b3, section 7).
enum class ModbusException : std::uint8_t { illegal_function = 1, illegal_address = 2, illegal_value = 3 };

class ServedRegisters {
 public:
  virtual ~ServedRegisters() = default;
  [[nodiscard]] virtual const drivers::RegisterMap& map() const = 0;
  /// Returns whether the unit stays silent instead of sending an exception reply.
  [[nodiscard]] virtual bool is_silent_on_errors() const { return false; }

  /// Appends `count` registers to `words`. Fails with illegal_value if `count` exceeds the map's limit, or with
  /// illegal_address if the map does not contain a register.
  [[nodiscard]] virtual tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                                 std::uint16_t count,
                                                                 std::vector<std::uint16_t>& words) const = 0;
  /// Writes all registers or none. Fails with illegal_address if a register is not writable or if only a part of an
  /// item is written, or with illegal_value if the unit does not accept a value.
  [[nodiscard]] virtual tl::expected<void, ModbusException> write(drivers::WriteFunction function,
                                                                  std::uint16_t address,
                                                                  std::span<const std::uint16_t> words) = 0;
};

}  // namespace gyrotherm::simulator
