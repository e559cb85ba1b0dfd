// SPDX-License-Identifier: Apache-2.0
/// Finite-element model of a rig's virtual gyro, for the report.
#pragma once

#include "core/result.hpp"
#include "report/thermal_model.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Returns the finite-element model from which the rig's gyro was reduced, with a thermal image that gyrotherm-thermal
/// computes in about a second. If there is none, returns the reason: the rig is real, its gyro has no finite elements,
/// the gyro file is missing or has changed, or the program failed. Fails only with interrupted.
[[nodiscard]] Result<report::ReportedThermal> find_thermal_model(const rig::RigFile& rig);

}  // namespace gyrotherm::app
