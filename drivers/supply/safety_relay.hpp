// SPDX-License-Identifier: Apache-2.0
/// A relay that disconnects a chamber, on a line of its own: a coil or a register of a Modbus unit, or an instrument
/// with text commands. The watchdog opens it if the chamber cannot be made safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/line/link_settings.hpp"

namespace gyrotherm::drivers {

enum class RelayPosition { open, closed };
[[nodiscard]] inline const char* name(RelayPosition position) {
  return position == RelayPosition::open ? "open" : "closed";
}

enum class RelayKind { coil, one_register, text };

/// Lines of a relay with text commands. An answer must be equal to one of the two texts.
struct RelayTexts {
  std::string tell_open{}, tell_close{}, ask{};
  std::string is_open{}, is_closed{};
  bool operator==(const RelayTexts&) const = default;
};

struct RelaySettings {
  std::string line;
  RelayKind kind{};
  std::uint16_t address{};
  /// Values of the coil or register in both positions.
  std::uint16_t open_value = 0, closed_value = 1;
  RelayTexts texts{};
  /// Modbus RTU frames over TCP.
  bool is_rtu_over_tcp{};
  LinkSettings link{};
  /// Time that the watchdog has to make the chamber safe before it opens the relay.
  Duration after = std::chrono::seconds(30);
  bool operator==(const RelaySettings&) const = default;
};

/// Reads the table [safe.also] of a rig file. Records errors in it.
[[nodiscard]] RelaySettings read_relay_settings(const TomlTable& table);
/// Writes the settings as an inline TOML table for read_relay_settings().
[[nodiscard]] std::string to_toml(const RelaySettings& settings);
/// Returns a text such as "coil 3 of tcp://10.0.0.9:502, opened after 30 s".
[[nodiscard]] std::string describe(const RelaySettings& settings);

class SafetyRelay {
 public:
  virtual ~SafetyRelay() = default;
  /// Reads the position. Fails with timeout, disconnected, refused or corrupted, and with mismatch if the unit reports
  /// neither position.
  [[nodiscard]] virtual Result<RelayPosition> read() = 0;
  /// Commands a position. An acknowledged command may have no effect.
  [[nodiscard]] virtual Result<void> command(RelayPosition position) = 0;
};

/// Makes the driver of a relay on its line, which opens at first use.
[[nodiscard]] std::unique_ptr<SafetyRelay> make_safety_relay(const RelaySettings& settings);

/// Commands a position and reads it back for up to two seconds, or three seconds if it does not answer. Repeats
/// a command that failed. `wait` lets time pass. Fails with mismatch if the relay keeps the other position, and
/// otherwise with the last fault.
[[nodiscard]] Result<void> switch_relay(SafetyRelay& relay, RelayPosition position,
                                        const std::function<void(Duration)>& wait);

}  // namespace gyrotherm::drivers
