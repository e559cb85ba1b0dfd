// SPDX-License-Identifier: Apache-2.0
/// The `link` table of an instrument in a rig file: settings of its link that belong to this installation.
#pragma once

#include <optional>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/line/link_settings.hpp"

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
                                                             const drivers::LinkSettings& settings) {
  auto set = with_settings(map, settings);
  if (set) return std::move(*set);
  instrument.table("link").mistake(set.error().where, set.error().what);
  return map;
}

}  // namespace gyrotherm::rig
