// SPDX-License-Identifier: Apache-2.0
/// The safe-state file: while a run may move a real chamber, it contains all data that another program needs to make
/// the chamber safe. The file is next to the record. It is created by a rename before the first command, and removed
/// when the run has ended in order.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/supply/safety_relay.hpp"
#include "sequencer/watchdog/guard.hpp"
#include "sequencer/watchdog/safe_evidence.hpp"

namespace gyrotherm::watchdog {

inline constexpr std::string_view kSafeStateSchema = "gyrotherm-safe-state/2";
/// Format of version 0.1.0, which is also read: missing keys take their defaults.
inline constexpr std::string_view kPreviousSafeStateSchema = "gyrotherm-safe-state/1";

struct SafeState {
  std::string record;  ///< absolute path
  /// The chamber's line, as in rig files.
  std::string line;
  /// The link of the map that the line uses.
  drivers::LinkKind link{};
  /// The rig's word order if it replaces the map's.
  std::optional<drivers::WordOrder> word_order;
  drivers::LinkSettings link_settings{};  ///< replaces the map's settings
  drivers::TextParameters parameters{};   ///< replaces those of a text unit
  Celsius safe_set_point;
  /// Conditioning must also be switched off.
  bool switch_off{};
  /// The controller carries out the profile, so its program must be ended first.
  bool by_program{};
  /// Time to watch the air.
  Duration observe = kUsualObserve;
  /// The controller's temperature unit and decimals, as last read.
  drivers::ControllerSettings settings{};
  /// The process that commands the chamber.
  ProcessIdentity written_by;
  std::string map_text;  ///< the register map
  /// Power switch of the map; may be empty.
  std::string power{};
  /// Identity of the chamber; empty: unknown.
  std::string identity{};
  /// Relay that is opened if the chamber cannot be made safe; absent: there is none.
  std::optional<drivers::RelaySettings> also{};
  bool operator==(const SafeState&) const = default;
};

/// Returns the file's path: "RUN.db" → "RUN.db.safe-state".
[[nodiscard]] std::string safe_state_path(const std::string& record);

/// Writes the file as TOML, with the map at the end as a list of its lines.
[[nodiscard]] std::string to_text(const SafeState& safe_state);
/// Parses the file. Fails with bad_file if to_text() does not write such a text. `file` is its path, for faults.
[[nodiscard]] Result<SafeState> parse_safe_state(std::string_view text, const std::string& file);
/// Returns nothing if there is no such file. Fails with bad_file, also if the file belongs neither to this user nor to
/// root, or if other users may write it, because the file determines which process is killed and which set point the
/// chamber receives.
[[nodiscard]] Result<std::optional<SafeState>> read_safe_state(const std::string& file);

/// Writes the safe-state file of its record, mode 0640. Fails with storage, also if the path is not UTF-8.
[[nodiscard]] Result<void> write_safe_state(const SafeState& safe_state);
/// Removes the file, if there is one.
void remove_safe_state(const std::string& record);

// The trace of gyrotherm-make-safe: a small text next to the record. It states when the program acted, and whether the
// chamber confirmed it.

inline constexpr std::string_view kMadeSafeSchema = "gyrotherm-made-safe/1";

struct MadeSafe {
  Duration at{};        ///< UTC since 1970
  std::string because;  ///< "the program that drove it has ended", …
  Celsius set_point;
  /// Set point, mode and air were shown.
  bool confirmed{};
  /// The chamber's answer, or the reason why it could not be reached.
  std::string details;
  /// State of the relay of [safe.also] if it was commanded; empty: it was not.
  std::string relay{};
  /// Program that acted; empty: the guard.
  std::string by{};
  /// User who ended the attempts, and the reason; empty: nobody did.
  std::string given_up{};
  bool operator==(const MadeSafe&) const = default;
};

/// Returns the trace's path: "RUN.db" → "RUN.db.made-safe".
[[nodiscard]] std::string made_safe_path(const std::string& record);

[[nodiscard]] std::string to_text(const MadeSafe& trace);
/// Parses a trace. Fails with bad_file if to_text() does not write such a text. `file` is its path, for faults.
[[nodiscard]] Result<MadeSafe> parse_made_safe(std::string_view text, const std::string& file);

/// Replaces the trace of that record. Fails with storage.
[[nodiscard]] Result<void> write_trace(const std::string& record, const MadeSafe& trace);
/// Returns nothing if there is no trace. Fails with bad_file.
[[nodiscard]] Result<std::optional<MadeSafe>> read_trace(const std::string& record);

/// Returns true if neither a safe-state file nor a trace is next to the record. A program that dies leaves the former,
/// a guard the latter, so the program itself released the chamber, or the files were moved.
[[nodiscard]] bool was_released(const std::string& record);

// The order to end the attempts: a line of text next to the record, which gyrotherm-make-safe --give-up writes. A guard
// carries it out, removes it, and leaves its trace.

/// Returns the order's path: "RUN.db" → "RUN.db.give-up".
[[nodiscard]] std::string give_up_path(const std::string& record);
/// Writes the order. Fails with storage.
[[nodiscard]] Result<void> write_give_up(const std::string& record, const std::string& who_and_why);
/// Returns the order; empty if there is none, or if the file belongs neither to this user nor to root.
[[nodiscard]] std::string read_give_up(const std::string& record);
/// Removes the order, if there is one.
void remove_give_up(const std::string& record);

/// Returns a text such as "made safe by the guard at 2026-01-01T00:00:00Z (…): the chamber was sent to 23 °C; …".
[[nodiscard]] std::string describe(const MadeSafe& trace);

}  // namespace gyrotherm::watchdog
