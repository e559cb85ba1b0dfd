// SPDX-License-Identifier: Apache-2.0
/// The registers of a virtual Modbus unit, as whoever serves its line needs them.
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
  /// No reply where others answer with an exception.
  [[nodiscard]] virtual bool is_silent_when_wrong() const { return false; }

  /// Appends `count` words to `words`. Fails with illegal_value if the map reads fewer at once, or illegal_address at a
  /// register that is none of the map's.
  [[nodiscard]] virtual tl::expected<void, ModbusException> read(drivers::ReadFunction function, std::uint16_t address,
                                                                 std::uint16_t count,
                                                                 std::vector<std::uint16_t>& words) const = 0;
  /// All or nothing. Fails with illegal_address at a register that is not writable or belongs to an item written in
  /// part, or illegal_value if the unit does not accept what is written.
  [[nodiscard]] virtual tl::expected<void, ModbusException> write(drivers::WriteFunction function,
                                                                  std::uint16_t address,
                                                                  std::span<const std::uint16_t> words) = 0;
};

}  // namespace gyrotherm::simulator
