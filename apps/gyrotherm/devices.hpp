// SPDX-License-Identifier: Apache-2.0
/// What is plugged in, whether this user may open it, and what to do if not.
#pragma once

#include <string>
#include <vector>

namespace gyrotherm::app {

/// A device file, and whether it may be read and written.
struct Node {
  std::string path;
  bool allowed{};
  std::string group;  ///< that owns it; empty if it is not there
};
[[nodiscard]] Node node_at(const std::string& path);

/// The command that allows the use of a serial port; empty if it is allowed.
[[nodiscard]] std::string fix_of_serial(const Node& node);
/// … of an HID device.
[[nodiscard]] std::string fix_of_hid(const Node& node);

/// One thing that is plugged in.
struct Device {
  Node node;
  bool is_hid{};
  std::string line{};  ///< for a rig file; empty if no driver speaks to it
  std::string description{};
  std::string usb{};     ///< "0403:6001", vendor and product; empty if it is not on USB
  std::string serial{};  ///< its number there
  std::string driver{};  ///< of an HID device; empty if none speaks to it
  std::string fix{};     ///< commands that allow its use, if it is not allowed
};

/// Serial ports and HID devices.
[[nodiscard]] std::vector<Device> all_devices();

}  // namespace gyrotherm::app
