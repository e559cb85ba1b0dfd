// SPDX-License-Identifier: Apache-2.0
/// Checks whether the machine is suitable for runs that take days. `doctor` prints the findings together with those
/// about the instruments. No check writes to a disk or communicates with an instrument.
#pragma once

#include <string>
#include <vector>

#include "apps/gyrotherm/devices.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

enum class FindingState { ok, warning, fault };

[[nodiscard]] constexpr const char* name(FindingState state) {
  return enumerator_text<FindingState::fault>({"ok", "warning", "fault"}, state);
}

/// Result of one check.
struct Finding {
  std::string what;  ///< "disk", "line of the chamber"
  FindingState state{};
  std::string found;
  std::string fix;  ///< empty if ok
  /// Kind of fault if the check failed; determines the exit code.
  FaultKind kind = FaultKind::disconnected;
};

/// Checks the files of the program: shipped profiles, gyrotherm-make-safe, gyrotherm-pdf.
[[nodiscard]] std::vector<Finding> check_installation();

/// Checks the disk of a folder for records: permission to write, free space, inodes, kind of file system.
[[nodiscard]] std::vector<Finding> check_disk(const std::string& folder);

/// Checks whether the kernel reports the clock as synchronised with UTC.
[[nodiscard]] Finding check_clock();

/// Checks the limits of this process, which a run inherits: open files, file size, processor time, memory, locked
/// memory, priority.
[[nodiscard]] std::vector<Finding> check_limits();

// Programs and settings that disturb serial adapters: ModemManager sends AT commands to every new port, brltty takes
// adapters for braille displays, USB autosuspend switches adapters off.

/// Checks /proc, /sys, /run/udev and the udev rules below `root`, and the USB serial adapters among `devices`. Returns
/// a finding about ModemManager, one about brltty, and one for each adapter that may be suspended.
[[nodiscard]] std::vector<Finding> check_serial_adapters(const std::vector<Device>& devices,
                                                         const std::string& root = "");

}  // namespace gyrotherm::app
