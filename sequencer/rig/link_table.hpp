// SPDX-License-Identifier: Apache-2.0
/// The `link` table of an instrument in a rig file: settings of its link that belong to this installation.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/link_settings.hpp"
#include "sequencer/rig/thermometer_settings.hpp"

namespace gyrotherm::rig {

/// Reads a word of the instrument's table or of its `link` table; in both it is a mistake. Returns nothing if it is
/// absent or "default".
template <class Words>
[[nodiscard]] auto one_of_link(const Words& words, const TomlTable& instrument, const char* key) {
  const auto link = instrument.table("link");
  if (instrument.has(key) && link.has(key)) link.mistake(key, "is in the instrument's own table too, expected it once");
  return one_of_or_default(words, link.has(key) ? link : instrument, key);
}

/// Returns the map with the instrument's `link` settings. A setting that its link in use cannot have is a mistake.
[[nodiscard]] inline drivers::RegisterMap with_link_settings(drivers::RegisterMap map, const TomlTable& instrument,
                                                             const std::string& line,
                                                             const drivers::LinkSettings& settings) {
  const auto link = instrument.table("link");
  if (line == kVirtualLine && settings.echo.value_or(false)) {
    link.mistake("echo", "a virtual line does not echo");
    return map;
  }
  if (line == kVirtualLine && settings.unit.value_or(map.link.modbus.unit) != map.link.modbus.unit)
    link.mistake("unit", "a virtual unit has the number of its map");
  auto set = with_settings(map, settings);
  if (set) return std::move(*set);
  link.mistake(set.error().where, set.error().what);
  return map;
}

}  // namespace gyrotherm::rig
