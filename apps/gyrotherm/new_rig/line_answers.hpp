// SPDX-License-Identifier: Apache-2.0
/// Answers that are the line of an instrument.
#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::app {

/// Returns the line for a rig file from an answer: "tcp://10.0.0.7:502", "10.0.0.7", "serial:/dev/ttyUSB0?9600,8N1" or
/// "/dev/ttyUSB0". A connected USB adapter is named by its path under /dev/serial/by-id. Fails with usage for a line
/// that carries no bytes, or a virtual one.
[[nodiscard]] Result<std::string> read_byte_line(const std::string& answer);

/// Returns the line of an HID device from "hid:01A2B3C4", "hid:" or the serial number alone.
[[nodiscard]] Result<std::string> read_hid_line(const std::string& answer);

/// Fails with usage if `line` is a port or device that is among `others`.
[[nodiscard]] Result<void> check_separate_line(const std::string& line, const std::vector<std::string>& others);

/// Returns the lines of the serial ports and HID devices of this machine, with their descriptions.
[[nodiscard]] std::vector<std::string> list_connected_lines();

}  // namespace gyrotherm::app
