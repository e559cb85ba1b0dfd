// SPDX-License-Identifier: Apache-2.0
/// Reads rig files together with the certificate files that they name.
#pragma once

#include <string>

#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Reads a rig file, or the shipped rig of that name. Verifies the certificate files of its thermometers. Fails as
/// rig::read_rig() and report::verify_temperature_certificate() do.
[[nodiscard]] Result<rig::RigFile> load_rig(const std::string& given);

}  // namespace gyrotherm::app
