// SPDX-License-Identifier: Apache-2.0
/// Listing of HID devices, and communication with one of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// USB identifiers of an HID model, and its name for messages.
struct HidKind {
  std::uint16_t vendor{}, product{};
  const char* name = "";
};

/// Returns the device of one of these kinds that has the serial number `serial`, or the only device of these kinds if
/// `serial` is empty. It is opened at first use. After it was unplugged, it is searched for at all ports. Opening
/// discards input reports that answer earlier queries. After the second consecutive failure, calls fail immediately for
/// 0.5 s, then for longer periods up to 10 s.
[[nodiscard]] std::unique_ptr<HidReports> make_hid_line(std::vector<HidKind> kinds, std::string serial);

/// Converts a text that a device reports to printable ASCII. Replaces every other character by a question mark: a
/// control character in a serial number could forge a line of a message. Returns "" for a null pointer.
[[nodiscard]] std::string to_printable_ascii(const wchar_t* text);

struct HidDeviceFound {
  /// Path such as "/dev/hidraw0". It may change when the device is plugged in again.
  std::string path;
  std::uint16_t vendor{}, product{};
  /// Texts that the device reports, in printable ASCII.
  std::string serial, maker, model;
};
/// Lists the connected HID devices, sorted by path.
[[nodiscard]] std::vector<HidDeviceFound> list_hid_devices();

}  // namespace gyrotherm::drivers
