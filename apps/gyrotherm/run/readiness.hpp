// SPDX-License-Identifier: Apache-2.0
/// The go/no-go block before a run: what a person should know before anything moves.
#pragma once

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/gyrotherm/machine_checks.hpp"
#include "core/quantity.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Returns where the zero of the bias comes from. A warning if the Earth rate of an axis is unknown: the mean of the
/// first hold is then its zero.
[[nodiscard]] Finding check_bias_zero(const rig::RigFile& rig);

/// Returns the zero of the bias, the calibrations on that day, the chamber's limiter, the disk of the record and the
/// guard. A virtual rig has neither limiter nor guard.
[[nodiscard]] std::vector<Finding> check_readiness(const rig::RigFile& rig, const std::string& record, Duration utc);

/// Prints the findings and the verdict: GO, GO WITH n WARNINGS or NO-GO. Of a virtual rig it prints warnings alone.
void say_readiness(Console& console, const rig::RigFile& rig, const std::vector<Finding>& findings);

}  // namespace gyrotherm::app
