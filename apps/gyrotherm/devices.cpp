// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/devices.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "core/shipped.hpp"
#include "core/toml_text.hpp"
#include "drivers/line/byte_streams.hpp"
#include "drivers/line/hid_line.hpp"
#include "drivers/thermometer/mcc_usb_temp.hpp"

namespace gyrotherm::app {
namespace {

constexpr const char* kRules = "60-gyrotherm.rules";
constexpr const char* kRulesFolder = "/etc/udev/rules.d";
constexpr const char* kReloadCommand = "sudo udevadm control --reload && sudo udevadm trigger";
constexpr const char* kJoinCommand = "sudo usermod -aG dialout \"$USER\"";

const char* driver_for(const drivers::HidDeviceFound& device) {
  for (const auto& kind : drivers::kMccKinds)
    if (kind.vendor == device.vendor && kind.product == device.product) return kind.name;
  return "";
}

/// Returns whether the rules are installed in any folder that udev reads.
bool has_rules() {
  constexpr std::array kFolders{kRulesFolder, "/usr/local/lib/udev/rules.d", "/usr/lib/udev/rules.d",
                                "/lib/udev/rules.d"};
  return std::ranges::any_of(kFolders, [](const char* folder) {
    std::error_code error;
    return std::filesystem::exists(std::filesystem::path(folder) / kRules, error);
  });
}

Device serial_device(const drivers::SerialPortFound& port) {
  Device device{.node = node_at(port.device), .description = port.description, .serial = port.serial};
  device.line = "serial:" + (port.stable_name.empty() ? port.device : port.stable_name);
  device.fix = serial_access_command(device.node);
  if (port.vendor != 0) device.usb = fmt::format("{:04x}:{:04x}", port.vendor, port.product);
  return device;
}

Device hid_device(const drivers::HidDeviceFound& found) {
  Device device{.node = node_at(found.path), .is_hid = true, .serial = found.serial, .driver = driver_for(found)};
  device.usb = fmt::format("{:04x}:{:04x}", found.vendor, found.product);
  device.description = fmt::format("{} {} {}", device.usb, found.maker, found.model);
  if (device.driver.empty()) return device;
  device.line = "hid:" + found.serial;
  device.fix = hid_access_command(device.node);
  return device;
}

}  // namespace

Node node_at(const std::string& path) {
  Node node{path, faccessat(AT_FDCWD, path.c_str(), R_OK | W_OK, AT_EACCESS) == 0, ""};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return node;
  const auto* group = getgrgid(status.st_gid);
  node.group = group != nullptr ? group->gr_name : std::to_string(status.st_gid);
  return node;
}

/// The ports of some adapters belong to root until a udev rule changes that.
std::string serial_access_command(const Node& node) {
  if (node.allowed) return "";
  if (node.group != "root") return fmt::format("sudo usermod -aG {} \"$USER\"   # then log in again", node.group);
  return fmt::format(
      "echo 'KERNEL==\"{}\", GROUP=\"dialout\", MODE=\"0660\"' | sudo tee {}/60-serial.rules && {} && {}   # then log "
      "in again",
      std::filesystem::path(node.path).filename().string(), kRulesFolder, kReloadCommand, kJoinCommand);
}

std::string hid_access_command(const Node& node) {
  if (node.allowed) return "";
  const auto shipped = find_shipped_file(std::string("drivers/") + kRules);
  const auto install =
      has_rules() || shipped.empty()
          ? ""
          : fmt::format("sudo install -m 644 {} {} && ", std::filesystem::absolute(shipped).string(), kRulesFolder);
  return fmt::format("{}{}   # for remote sessions also: {}, then log in again", install, kReloadCommand, kJoinCommand);
}

std::vector<std::string> rig_file_lines(const Device& device) {
  if (device.line.empty()) return {};
  const auto line = "line = " + toml_quoted(device.line);
  if (device.is_hid) return {"[[thermometer]]", "driver = \"mcc_usb_temp\"", line};
  const bool is_stable = device.line.find("/by-id/") != std::string::npos;
  return {
      fmt::format("{}  # {}append ?BAUD,FORMAT, such as ?9600,8N1, if the instrument is set otherwise than delivered",
                  line, is_stable ? "" : "this name may change; ")};
}

std::vector<Device> all_devices() {
  std::vector<Device> devices;
  for (const auto& port : drivers::list_serial_ports()) devices.push_back(serial_device(port));
  for (const auto& found : drivers::list_hid_devices()) devices.push_back(hid_device(found));
  return devices;
}

}  // namespace gyrotherm::app
