// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/line_answers.hpp"

#include <fmt/format.h>

#include <utility>
#include <variant>

#include "apps/gyrotherm/devices.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/line_address.hpp"

namespace gyrotherm::app {
namespace {

/// Returns the stable name of a connected serial port, or `device` if it has none.
std::string stable_device(const std::string& device) {
  for (const auto& port : drivers::list_serial_ports())
    if (port.device == device && !port.stable_name.empty()) return port.stable_name;
  return device;
}

/// Returns the port or device that only one instrument can use; empty for a network address.
std::string exclusive_device(const std::string& line) {
  const auto parsed = drivers::parse_line(line);
  if (!parsed) return {};
  if (const auto* serial = std::get_if<drivers::SerialLine>(&*parsed)) return serial->device;
  return std::holds_alternative<drivers::HidLine>(*parsed) ? line : "";
}

}  // namespace

Result<std::string> read_byte_line(const std::string& answer) {
  auto line = drivers::parse_line(answer.starts_with("/dev/") ? "serial:" + answer : answer);
  if (!line) return failure(FaultKind::usage, "", line.error().what);
  if (std::holds_alternative<drivers::VirtualLine>(*line))
    return failure(FaultKind::usage, "",
                   "a real rig has no virtual line; \"gyrotherm simulate\" serves virtual instruments by TCP");
  if (!drivers::is_byte_line(*line))
    return failure(FaultKind::usage, "", "this instrument is not an HID device, expected a tcp:// or serial: line");
  if (auto* serial = std::get_if<drivers::SerialLine>(&*line)) serial->device = stable_device(serial->device);
  return text(*line);
}

Result<std::string> read_hid_line(const std::string& answer) {
  const auto line = answer.starts_with("hid:") ? answer : "hid:" + answer;
  if (line.find_first_of("/ \t") != std::string::npos || answer.starts_with("tcp:") || answer.starts_with("serial:"))
    return failure(
        FaultKind::usage, "",
        fmt::format("\"{}\" is not an HID device, expected hid:SERIAL, or hid: if only one is connected", answer));
  return line;
}

Result<void> check_separate_line(const std::string& line, const std::vector<std::string>& others) {
  const auto device = exclusive_device(line);
  if (device.empty()) return {};
  for (const auto& other : others)
    if (exclusive_device(other) == device)
      return failure(FaultKind::usage, "", fmt::format("{} is already the line of another instrument", device));
  return {};
}

std::vector<std::string> list_connected_lines() {
  std::vector<std::string> lines;
  for (const auto& device : all_devices())
    if (!device.line.empty()) lines.push_back(fmt::format("{}  ({})", device.line, device.description));
  return lines;
}

}  // namespace gyrotherm::app
