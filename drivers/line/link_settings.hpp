// SPDX-License-Identifier: Apache-2.0
/// Settings of a link that depend on the installation and not on the instrument's model: the unit number, the
/// timeout of a slow gateway, an adapter that echoes, and deviations from the standard.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "drivers/line/modbus.hpp"

namespace gyrotherm::drivers {

/// Maximum pause between two lines or telegrams. A run reads once a second.
inline constexpr Duration kMaxPause = std::chrono::seconds(10);

/// Notes an error if a duration is longer than `longest`: "timeout is 20 s, expected at most 4 s".
void check_longest(const TomlTable& table, const char* key, Duration time, Duration longest);

/// Overrides of the link settings in an instrument's map. An empty member keeps the map's value.
struct LinkSettings {
  std::optional<std::uint8_t> unit{};
  std::optional<Duration> timeout{};
  /// Maximum number of registers in one exchange.
  std::optional<std::uint16_t> read_at_most{};
  /// RTU (see ModbusLink) and lines of text: the line returns every request.
  std::optional<bool> echo{};
  /// Pause after a write or command, or after its acknowledgement.
  std::optional<Duration> after_write{};
  std::optional<Duration> after_read{};  ///< lines of text: pause after an answer
  /// Modbus TCP: see ModbusLink.
  std::optional<bool> returns_other_transaction{}, returns_other_unit{}, miscounts_write_replies{};
  bool operator==(const LinkSettings&) const = default;
};

/// Reads the keys of a link table. Notes errors in the table.
[[nodiscard]] LinkSettings read_link_settings(const TomlTable& table);
/// Reads only the keys that a line of text can have: unit, timeout, echo and pauses.
[[nodiscard]] LinkSettings read_line_settings(const TomlTable& table);

/// Formats the settings as an inline TOML table, "{ unit = 2, echo = true }", for read_link_settings().
[[nodiscard]] std::string to_toml(const LinkSettings& settings);

/// Returns the link with the non-empty members of `settings` applied.
[[nodiscard]] ModbusLink apply_settings(ModbusLink link, const LinkSettings& settings);

/// Fails with usage if `settings` has a key that does not exist in the framing of `link`; `where` is the key.
[[nodiscard]] Result<void> check_framing(const ModbusLink& link, const LinkSettings& settings);
/// Fails with usage if `settings` has a key that exists only on a Modbus link; `where` is the key.
[[nodiscard]] Result<void> check_text_settings(const LinkSettings& settings);

}  // namespace gyrotherm::drivers
