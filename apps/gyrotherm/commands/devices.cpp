// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/devices.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "apps/console/command.hpp"
#include "core/json.hpp"

namespace gyrotherm::app {
namespace {

Json device_json(const Device& device) {
  Json facts{{"kind", device.is_hid ? "hid" : "serial"},
             {"device", device.node.path},
             {"line", device.line},
             {"toml", rig_file_lines(device)},
             {"description", device.description}};
  if (!device.usb.empty()) facts.update({{"usb", device.usb}, {"serial", device.serial}});
  if (device.is_hid) facts["driver"] = device.driver;
  facts.update({{"allowed", device.node.allowed}, {"group", device.node.group}});
  if (!device.fix.empty()) facts["fix"] = device.fix;
  return facts;
}

std::string describe(const std::vector<Device>& devices) {
  if (devices.empty()) return "no serial port and no HID device found\n";
  std::string text;
  for (const auto& device : devices) {
    text += fmt::format("{:<14} {:<12} {}\n", device.node.path, device.node.allowed ? "may be used" : "NOT ALLOWED",
                        device.description);
    const auto lines = rig_file_lines(device);
    text += lines.empty() ? "    no driver supports it\n" : "    in a rig file:\n";
    for (const auto& line : lines) text += fmt::format("      {}\n", line);
    if (!device.fix.empty()) text += fmt::format("    to permit it: {}\n", device.fix);
  }
  return text;
}

Result<Exit> list_devices(Console& console) {
  const auto devices = all_devices();
  auto json = Json::array();
  for (const auto& device : devices) json.push_back(device_json(device));
  console.print(console.json ? json_text(Json{{"devices", json}}) + "\n" : describe(devices));
  return Exit::done;
}

}  // namespace

void add_devices(Program& program) {
  auto& command = add_command(
      program, "devices", "Lists serial ports and HID devices, whether this user may open them, and how to permit it.",
      "gyrotherm devices");
  command.callback([&program] { program.outcome = list_devices(program.console); });
}

}  // namespace gyrotherm::app
