// SPDX-License-Identifier: Apache-2.0
/// HID devices: which there are, and speaking to one.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// A model, as it names itself on the bus.
struct HidKind {
  std::uint16_t vendor{}, product{};
  const char* name = "";
};

/// The device of one of these kinds with that serial number; with an empty one the only device of these kinds. Opened
/// at first use; after it was gone it is looked for among all devices again, at whatever port. After a second failure
/// in a row it is left alone for 0.5 s, then longer, up to 10 s. What an older question left to be read is thrown away
/// when it is opened.
[[nodiscard]] std::unique_ptr<HidReports> make_hid_line(std::vector<HidKind> kinds, std::string serial);

struct HidDeviceFound {
  std::string path;  ///< "/dev/hidraw0": changes from one plugging to the next
  std::uint16_t vendor{}, product{};
  std::string serial, maker, model;  ///< as the device says
};
[[nodiscard]] std::vector<HidDeviceFound> hid_devices();

}  // namespace gyrotherm::drivers
