// SPDX-License-Identifier: Apache-2.0
/// What is plugged in, whether this user may open it, and what to do if not.
#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "app/command.hpp"
#include "core/json.hpp"
#include "core/shipped.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kShippedRules = "drivers/60-gyrotherm.rules";
constexpr const char* kRulesFolder = "/etc/udev/rules.d";

/// A device file, and whether it may be read and written.
struct Node {
  std::string path;
  bool allowed{};
  std::string group;  ///< that owns it
};

Node node_at(const std::string& path) {
  Node node{path, faccessat(AT_FDCWD, path.c_str(), R_OK | W_OK, AT_EACCESS) == 0, ""};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return node;
  const auto* group = getgrgid(status.st_gid);
  node.group = group != nullptr ? group->gr_name : std::to_string(status.st_gid);
  return node;
}

const char* supported_as(const drivers::HidDeviceFound& device) {
  for (const auto& kind : drivers::kMccKinds)
    if (kind.vendor == device.vendor && kind.product == device.product) return kind.name;
  return "";
}

/// One thing that is plugged in.
struct Device {
  Node node;
  std::string line;  ///< for a rig file; empty if no driver speaks to it
  std::string description;
  std::string fix;  ///< commands that allow its use, if it is not allowed
  Json facts;
};

/// Ports of some adapters belong to root alone until a rule says otherwise.
std::string fix_of_serial(const Node& node) {
  if (node.allowed) return "";
  if (node.group != "root") return fmt::format("sudo usermod -aG {} \"$USER\"   # then log in again", node.group);
  return fmt::format(
      "echo 'KERNEL==\"{}\", GROUP=\"dialout\", MODE=\"0660\"' | sudo tee {}/60-serial.rules && sudo udevadm control "
      "--reload && sudo udevadm trigger && sudo usermod -aG dialout \"$USER\"   # then log in again",
      std::filesystem::path(node.path).filename().string(), kRulesFolder);
}

std::string fix_of_hid(const Node& node) {
  if (node.allowed) return "";
  const auto rules = shipped_file(kShippedRules);
  return fmt::format(
      "sudo install -m 644 {} {} && sudo udevadm control --reload && sudo udevadm trigger   # and, not sitting at the "
      "machine: sudo usermod -aG dialout \"$USER\", log in again",
      std::filesystem::absolute(rules).string(), kRulesFolder);
}

Device serial_device(const drivers::SerialPortFound& port) {
  Device device{.node = node_at(port.device), .line = "", .description = port.description, .fix = "", .facts = {}};
  device.line = "serial:" + (port.stable_name.empty() ? port.device : port.stable_name);
  device.fix = fix_of_serial(device.node);
  device.facts = {
      {"kind", "serial"}, {"device", port.device}, {"line", device.line}, {"description", port.description}};
  if (port.vendor != 0)
    device.facts.update({{"usb", fmt::format("{:04x}:{:04x}", port.vendor, port.product)}, {"serial", port.serial}});
  return device;
}

Device hid_device_of(const drivers::HidDeviceFound& found) {
  const std::string name = supported_as(found);
  const auto id = fmt::format("{:04x}:{:04x}", found.vendor, found.product);
  Device device{.node = node_at(found.path), .line = "", .description = "", .fix = "", .facts = {}};
  if (!name.empty()) device.line = "hid:" + found.serial;
  if (!name.empty()) device.fix = fix_of_hid(device.node);
  device.description = fmt::format("{} {} {}", id, found.maker, found.model);
  device.facts = {{"kind", "hid"},          {"device", found.path},       {"line", device.line}, {"usb", id},
                  {"serial", found.serial}, {"description", found.model}, {"driver", name}};
  return device;
}

std::vector<Device> all_devices() {
  std::vector<Device> devices;
  for (const auto& port : drivers::serial_ports()) devices.push_back(serial_device(port));
  for (const auto& found : drivers::hid_devices()) devices.push_back(hid_device_of(found));
  for (auto& device : devices) {
    device.facts.update({{"allowed", device.node.allowed}, {"group", device.node.group}});
    if (!device.fix.empty()) device.facts["fix"] = device.fix;
  }
  return devices;
}

std::string describe(const std::vector<Device>& devices) {
  if (devices.empty()) return "no serial port and no HID device is there\n";
  std::string words;
  for (const auto& device : devices) {
    words += fmt::format("{:<14} {:<12} {}\n", device.node.path, device.node.allowed ? "may be used" : "NOT ALLOWED",
                         device.description);
    words += device.line.empty() ? "    no driver here speaks to it\n"
                                 : fmt::format("    in a rig file: line = \"{}\"\n", device.line);
    if (!device.fix.empty()) words += fmt::format("    to allow it: {}\n", device.fix);
  }
  return words;
}

Result<Exit> list_devices(Console& console) {
  const auto devices = all_devices();
  auto json = Json::array();
  for (const auto& device : devices) json.push_back(device.facts);
  console.data(console.json ? text_of(Json{{"devices", json}}) + "\n" : describe(devices));
  return Exit::done;
}

}  // namespace

void add_devices(Program& program) {
  auto& command = add_command(program, "devices",
                              "Lists serial ports and HID devices, and whether this user may open them (with the fix "
                              "if not).",
                              "gyrotherm devices");
  command.callback([&program] { program.outcome = list_devices(program.console); });
}

}  // namespace gyrotherm::app
