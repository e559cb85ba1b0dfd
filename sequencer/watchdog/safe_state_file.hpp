// SPDX-License-Identifier: Apache-2.0
/// The safe-state file: while a run may move a real chamber, all that another program needs to make that chamber safe.
/// Beside the record; made by rename before the first command, removed when the run has ended in order.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "sequencer/watchdog/guard.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"

namespace gyrotherm::watchdog {

inline constexpr std::string_view kSafeStateSchema = "gyrotherm-safe-state/2";
/// Format of version 0.1.0, which is read too: the keys that it does not have take their defaults.
inline constexpr std::string_view kSafeStateSchemaBefore = "gyrotherm-safe-state/1";

struct SafeState {
  std::string record;                            ///< its path, absolute
  std::string line;                              ///< the chamber's, as rig files say it
  drivers::LinkKind link{};                      ///< which of the map's links is in use on that line
  std::optional<drivers::WordOrder> word_order;  ///< the rig's own, where the map's does not suit the unit
  drivers::LinkSettings link_settings{};         ///< replace those of the map
  Celsius safe_set_point;
  bool switch_off{};                       ///< then conditioning is ended too
  bool by_program{};                       ///< the controller carries the profile out: its program is ended first
  Duration observe = kUsualObserve;        ///< for which the air is watched
  drivers::ControllerSettings settings{};  ///< unit and decimals, as last read
  ProcessIdentity written_by;              ///< who commands the chamber meanwhile
  std::string map_text;                    ///< the register map
  std::string power{};                     ///< a power switch of the map, or empty
  std::string identity{};                  ///< of the chamber; empty: not known
  bool operator==(const SafeState&) const = default;
};

/// "RUN.db" → "RUN.db.safe-state".
[[nodiscard]] std::string safe_state_path(const std::string& record);

/// Writes it as TOML, the map at the end as a list of its lines.
[[nodiscard]] std::string to_text(const SafeState& safe_state);
/// Fails with bad_file if the text is not what to_text() writes; `file` is its place.
[[nodiscard]] Result<SafeState> parse_safe_state(std::string_view text, const std::string& file);
/// Returns nothing if there is no such file. Fails with bad_file, also if it belongs neither to this user nor to root,
/// or others may write it: whoever wrote it says which process is killed, and where a chamber is sent.
[[nodiscard]] Result<std::optional<SafeState>> read_safe_state(const std::string& file);

/// Writes the safe-state file of its record, mode 0640. Fails with storage, also where the path is not UTF-8.
[[nodiscard]] Result<void> write_safe_state(const SafeState& safe_state);
/// Removes it; nothing happens if there is none.
void remove_safe_state(const std::string& record);

// The trace of gyrotherm-make-safe: a small text beside the record that says when it acted and whether the chamber
// confirmed it.

inline constexpr std::string_view kMadeSafeSchema = "gyrotherm-made-safe/1";

struct MadeSafe {
  Duration at{};        ///< UTC since 1970
  std::string because;  ///< "the program that drove it has ended", …
  Celsius set_point;
  bool confirmed{};     ///< set point, mode and air were shown
  std::string details;  ///< what the chamber said, or why it could not be reached
  bool operator==(const MadeSafe&) const = default;
};

/// "RUN.db" → "RUN.db.made-safe".
[[nodiscard]] std::string made_safe_path(const std::string& record);

[[nodiscard]] std::string to_text(const MadeSafe& trace);
/// Fails with bad_file if the text is not what to_text() writes; `file` is its place.
[[nodiscard]] Result<MadeSafe> parse_made_safe(std::string_view text, const std::string& file);

/// Replaces the trace of that record. Fails with storage.
[[nodiscard]] Result<void> leave_trace(const std::string& record, const MadeSafe& trace);
/// Returns nothing if gyrotherm-make-safe has left none. Fails with bad_file.
[[nodiscard]] Result<std::optional<MadeSafe>> read_trace(const std::string& record);

/// "made safe by the guard at 2026-01-01T00:00:00Z (…): the chamber was sent to 23 °C; …"
[[nodiscard]] std::string describe(const MadeSafe& trace);

}  // namespace gyrotherm::watchdog
