// SPDX-License-Identifier: Apache-2.0
/// Connected devices, the user's access to them, and commands that grant access.
#pragma once

#include <string>
#include <vector>

namespace gyrotherm::app {

/// A device file, and whether it may be read and written.
struct Node {
  std::string path;
  bool allowed{};
  std::string group;  ///< empty if the file is missing
};
[[nodiscard]] Node node_at(const std::string& path);

/// Returns the command that grants access to a serial port, or an empty string if access is granted already.
[[nodiscard]] std::string serial_access_command(const Node& node);
/// Returns the command that grants access to an HID device, or an empty string if access is granted already.
[[nodiscard]] std::string hid_access_command(const Node& node);

/// Connected device.
struct Device {
  Node node;
  bool is_hid{};
  /// Line for a rig file; empty if no driver supports the device.
  std::string line{};
  std::string description{};
  std::string usb{};  ///< "0403:6001", vendor and product; otherwise empty
  std::string serial{};
  std::string driver{};  ///< only for HID devices
  /// Commands that grant access; empty if access is granted already.
  std::string fix{};
};

/// Returns the TOML lines for the instrument in a rig file; none if no driver supports the device.
[[nodiscard]] std::vector<std::string> rig_file_lines(const Device& device);

/// Lists serial ports and HID devices.
[[nodiscard]] std::vector<Device> all_devices();

}  // namespace gyrotherm::app
