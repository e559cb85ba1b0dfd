// SPDX-License-Identifier: Apache-2.0
/// Settings of a Modbus link that belong to one installation and not to a model: the unit's number, a slow gateway, an
/// adapter that echoes, a unit whose replies deviate from the standard. They replace those of the instrument's map.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

/// A member without a value leaves the map's own in force.
struct LinkSettings {
  std::optional<std::uint8_t> unit{};           ///< number on the bus
  std::optional<Duration> timeout{};            ///< one exchange
  std::optional<std::uint16_t> read_at_most{};  ///< registers in one exchange
  std::optional<bool> echo{};                   ///< RTU: see ModbusLink
  std::optional<bool> returns_other_transaction{}, returns_other_unit{}, miscounts_write_replies{};  ///< Modbus TCP
  bool operator==(const LinkSettings&) const = default;
};

/// Reads the keys of a link table. Mistakes are noted in the table.
[[nodiscard]] LinkSettings read_link_settings(const TomlTable& table);

/// Returns the settings as an inline TOML table, "{ unit = 2, echo = true }", that read_link_settings() reads.
[[nodiscard]] std::string to_toml(const LinkSettings& settings);

/// Returns the link with the values that `settings` has.
[[nodiscard]] ModbusLink with_settings(ModbusLink link, const LinkSettings& settings);

/// Fails with usage if `settings` has a key that the framing of `link` cannot have; `where` is the key.
[[nodiscard]] Result<void> check_framing(const ModbusLink& link, const LinkSettings& settings);

}  // namespace gyrotherm::drivers
