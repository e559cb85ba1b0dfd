// SPDX-License-Identifier: Apache-2.0
/// Whether this machine, as it is set up, can carry a run of days out: what `doctor` finds beside the instruments.
/// Nothing here writes to a disk or speaks to an instrument.
#pragma once

#include <string>
#include <vector>

#include "apps/gyrotherm/devices.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

enum class FindingState { ok, warning, fault };

[[nodiscard]] constexpr const char* name(FindingState state) {
  return word_in<FindingState::fault>({"ok", "warning", "fault"}, state);
}

/// One thing that was looked at.
struct Finding {
  std::string what;  ///< "disk", "line of the chamber"
  FindingState state{};
  std::string found;
  std::string fix;                           ///< where it is not ok
  FaultKind kind = FaultKind::disconnected;  ///< of a fault: what the exit code is made of
};

/// The program's own files: shipped profiles, gyrotherm-make-safe, gyrotherm-pdf.
[[nodiscard]] std::vector<Finding> check_installation();

/// The disk of a folder in which records are to be: whether it may be written, space, inodes, kind of file system.
[[nodiscard]] std::vector<Finding> check_disk(const std::string& folder);

/// Whether the machine's clock follows UTC, by the kernel's word.
[[nodiscard]] Finding check_clock();

/// Limits of this process, which a run started here would have: open files, size of files, processor time, memory,
/// locked memory, priority.
[[nodiscard]] std::vector<Finding> check_limits();

// Programs and settings that disturb serial adapters: ModemManager sends AT commands to every new port, brltty takes
// adapters for braille displays, USB autosuspend switches adapters off.

/// Looks at /proc, /sys, /run/udev and the udev rules below `root`, and at those of `devices` that are serial adapters
/// on USB. Returns a finding about ModemManager, one about brltty, and one for each adapter that may be suspended.
[[nodiscard]] std::vector<Finding> check_serial_adapters(const std::vector<Device>& devices,
                                                         const std::string& root = "");

}  // namespace gyrotherm::app
