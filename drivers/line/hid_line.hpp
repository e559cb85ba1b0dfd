// SPDX-License-Identifier: Apache-2.0
/// Listing of HID devices, and communication with one of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// An HID model by its USB identifiers, with its name for messages.
struct HidKind {
  std::uint16_t vendor{}, product{};
  const char* name = "";
};

/// Returns the device of one of these kinds with that serial number; if `serial` is empty, the only device of these
/// kinds. It is opened at first use, and searched for at all ports after it was unplugged. Opening discards input
/// reports of earlier queries. After the second consecutive failure, uses fail immediately for 0.5 s, then for longer
/// periods up to 10 s.
[[nodiscard]] std::unique_ptr<HidReports> make_hid_line(std::vector<HidKind> kinds, std::string serial);

struct HidDeviceFound {
  /// "/dev/hidraw0"; changes with each plugging in.
  std::string path;
  std::uint16_t vendor{}, product{};
  /// Texts that the device reports.
  std::string serial, maker, model;
};
[[nodiscard]] std::vector<HidDeviceFound> hid_devices();

}  // namespace gyrotherm::drivers
