// SPDX-License-Identifier: Apache-2.0
/// The `line` of an instrument in a rig file, and its `link` table: the settings of the link that belong to this
/// installation.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/link_settings.hpp"

namespace gyrotherm::rig {

inline constexpr std::string_view kVirtualLine = "virtual";
/// Time limit for connecting a TCP line.
inline constexpr Duration kConnectWithin = std::chrono::seconds(2);

/// Records an error if `line`, the value of the key "line", is an empty text. Returns whether it is empty; if the key
/// is missing, the reader has recorded an error already.
inline bool is_empty_line(const TomlTable& table, const std::string& line) {
  if (line.empty() && table.is_text("line"))
    table.note_error("line", "\"line\" is empty, expected tcp://A.B.C.D:PORT, serial:DEVICE, hid:SERIAL or virtual");
  return line.empty();
}

/// Records an error if `line` is not the address of a line that carries bytes.
inline void check_line(const TomlTable& table, const std::string& line) {
  if (is_empty_line(table, line)) return;
  const auto parsed = drivers::parse_line(line);
  if (!parsed) table.note_error("line", parsed.error().what);
  if (parsed && line != kVirtualLine && !drivers::is_byte_line(*parsed))
    table.note_error("line", "this instrument is not an HID device; expected a tcp:// or serial: line");
}

/// Reads a keyword from the instrument's table or from its `link` table. A keyword in both is an error. Returns nothing
/// if it is absent or "default".
template <class Words>
[[nodiscard]] auto read_link_keyword(const Words& words, const TomlTable& instrument, const char* key) {
  const auto link = instrument.table("link");
  if (instrument.has(key) && link.has(key))
    link.note_error(key, "is also in the instrument's own table, expected only one of them");
  return one_of_or_default(words, link.has(key) ? link : instrument, key);
}

/// Records an error for a parameter in the instrument's table `parameter` that its description does not have.
inline void note_unknown_parameter(const drivers::RegisterMap& map, const TomlTable& instrument,
                                   const drivers::TextParameters& parameters) {
  if (const auto known = check_parameters(map, parameters); !known)
    instrument.table("parameter").note_error(known.error().where, known.error().what);
}

/// Returns the map with the instrument's `link` settings. Records an error for a setting that the selected link cannot
/// have.
[[nodiscard]] inline drivers::RegisterMap apply_link_settings(drivers::RegisterMap map, const TomlTable& instrument,
                                                              const std::string& line,
                                                              const drivers::LinkSettings& settings) {
  const auto link = instrument.table("link");
  if (line == kVirtualLine && settings.echo.value_or(false)) {
    link.note_error("echo", "a virtual line does not echo");
    return map;
  }
  if (line == kVirtualLine && settings.unit.value_or(map.link.modbus.unit) != map.link.modbus.unit)
    link.note_error("unit", "a virtual unit has the number of its map");
  auto set = apply_settings(map, settings);
  if (set) return std::move(*set);
  link.note_error(set.error().where, set.error().what);
  return map;
}

}  // namespace gyrotherm::rig
