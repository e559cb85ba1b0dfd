// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/serial_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInstallRules = "gyrotherm devices lists the command that installs its udev rules";
/// Adapters that brltty's rules have claimed, as they write USB ids.
constexpr std::array<std::string_view, 4> kTakenByBrltty{"403/6001", "10c4/ea60", "67b/2303", "1a86/7523"};

/// Returns the text of a file of the system without blanks at its ends; empty if it cannot be read.
std::string content(const fs::path& file) {
  std::ifstream stream(file);
  std::string text;
  for (std::string line; std::getline(stream, line);) text += line + "\n";
  return std::string(trimmed(text, " \t\r\n"));
}

bool is_running(const std::string& program, const std::string& root) {
  return std::ranges::any_of(entries_of(root + "/proc"), [&](const auto& entry) {
    const auto name = entry.filename().string();
    return name.find_first_not_of("0123456789") == std::string::npos && content(entry / "comm") == program;
  });
}

std::string tty_of(const Device& device) { return fs::path(device.node.path).filename().string(); }

/// Returns whether a udev property keeps ModemManager from the port.
bool is_left_to_us(const Device& device, const std::string& root) {
  const auto number = content(root + "/sys/class/tty/" + tty_of(device) + "/dev");
  const auto properties = "\n" + content(root + "/run/udev/data/c" + number) + "\n";
  return properties.find("\nE:ID_MM_DEVICE_IGNORE=1\n") != std::string::npos ||
         properties.find("\nE:ID_MM_PORT_IGNORE=1\n") != std::string::npos;
}

Finding check_modem_manager(const std::vector<Device>& adapters, const std::string& root) {
  constexpr const char* kName = "ModemManager";
  if (!is_running(kName, root)) return {kName, FindingState::ok, "is not active", ""};
  std::vector<std::string> probed;
  for (const auto& device : adapters)
    if (!is_left_to_us(device, root)) probed.push_back(device.node.path);
  if (probed.empty()) return {kName, FindingState::ok, "leaves the serial adapters alone", ""};
  return {kName, FindingState::warning,
          fmt::format("is active and sends AT commands to {} when it is plugged in", fmt::join(probed, ", ")),
          fmt::format("{}; or: sudo systemctl disable --now ModemManager", kInstallRules)};
}

/// The first rules file of brltty that claims an adapter of a common kind; empty if there is none.
std::string rules_of_brltty(const std::string& root) {
  for (const auto* folder : {"/etc/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"})
    for (const auto& entry : entries_of(root + folder)) {
      if (entry.filename().string().find("brltty") == std::string::npos) continue;
      std::string rules = content(entry);
      for (std::size_t end; !rules.empty(); rules.erase(0, end)) {
        end = std::min(rules.find('\n'), rules.size() - 1) + 1;
        const auto line = std::string_view(rules).substr(0, end);
        if (!trimmed(line).starts_with('#') &&
            std::ranges::any_of(kTakenByBrltty, [&](auto id) { return line.find(id) != std::string_view::npos; }))
          return entry.string().substr(root.size());
      }
    }
  return {};
}

Finding check_brltty(const std::string& root) {
  constexpr const char* kName = "brltty";
  constexpr const char* kFix = "without a braille display: sudo apt-get remove brltty";
  if (is_running(kName, root))
    return {kName, FindingState::warning, "is active and may take serial adapters for braille displays", kFix};
  if (const auto rules = rules_of_brltty(root); !rules.empty())
    return {kName, FindingState::warning,
            fmt::format("takes common serial adapters for braille displays ({}): their ports disappear", rules), kFix};
  return {kName, FindingState::ok, "takes no serial adapter", ""};
}

/// The folder of a port's USB device in /sys; empty if it is not found.
fs::path usb_device(const Device& device, const std::string& root) {
  std::error_code error;
  auto folder = fs::canonical(root + "/sys/class/tty/" + tty_of(device) + "/device", error);
  while (!error && folder.has_relative_path() && folder != root) {
    if (fs::exists(folder / "idVendor", error)) return folder;
    folder = folder.parent_path();
  }
  return {};
}

std::vector<Finding> check_power(const std::vector<Device>& adapters, const std::string& root) {
  std::vector<Finding> findings;
  for (const auto& device : adapters) {
    const auto folder = usb_device(device, root);
    if (folder.empty() || content(folder / "power/control") != "auto") continue;
    findings.push_back(
        {"power of " + device.node.path, FindingState::warning,
         "USB autosuspend may switch the adapter off while its line is quiet",
         fmt::format("echo on | sudo tee {}/power/control; for good: {}", folder.string(), kInstallRules)});
  }
  return findings;
}

}  // namespace

std::vector<Finding> check_serial_adapters(const std::vector<Device>& devices, const std::string& root) {
  std::vector<Device> adapters;
  std::ranges::copy_if(devices, std::back_inserter(adapters),
                       [](const auto& device) { return !device.is_hid && !device.usb.empty(); });
  std::vector<Finding> findings{check_modem_manager(adapters, root), check_brltty(root)};
  std::ranges::move(check_power(adapters, root), std::back_inserter(findings));
  return findings;
}

}  // namespace gyrotherm::app
