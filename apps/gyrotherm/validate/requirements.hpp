// SPDX-License-Identifier: Apache-2.0
/// The requirements of a validation and their tests. Installation qualification (IQ) looks at the installed program and
/// the machine; operation qualification (OQ) uses the installed program like a user, and the rig file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/gyrotherm/validate/validation.hpp"
#include "core/result.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// What the tests of a validation use.
struct ValidationSite {
  const rig::RigFile& rig;
  /// Folder for records of the validation, which exists.
  std::string folder;
};

/// Tests every requirement in the order of the table. Calls `progress` with each result, and stops with interrupted if
/// it returns false.
[[nodiscard]] Result<std::vector<RequirementResult>> test_requirements(
    const ValidationSite& site, const std::function<bool(const RequirementResult&)>& progress);

/// Returns the programs of this installation with their digests.
[[nodiscard]] std::vector<InstalledProgram> list_installed_programs();

}  // namespace gyrotherm::app
