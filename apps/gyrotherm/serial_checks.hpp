// SPDX-License-Identifier: Apache-2.0
/// Programs and settings of this machine that disturb serial adapters: ModemManager sends AT commands to every new
/// port, brltty takes adapters for braille displays, USB autosuspend switches adapters off.
#pragma once

#include <string>
#include <vector>

#include "apps/gyrotherm/devices.hpp"
#include "apps/gyrotherm/machine_checks.hpp"

namespace gyrotherm::app {

/// Looks at /proc, /sys, /run/udev and the udev rules below `root`, and at those of `devices` that are serial adapters
/// on USB. Returns a finding about ModemManager, one about brltty, and one for each adapter that may be suspended.
[[nodiscard]] std::vector<Finding> check_serial_adapters(const std::vector<Device>& devices,
                                                         const std::string& root = "");

}  // namespace gyrotherm::app
