// SPDX-License-Identifier: Apache-2.0
/// Copies a rig file into another folder.
#pragma once

#include <string>

#include "core/result.hpp"

namespace gyrotherm::app {

/// Returns the text of a rig file, or of the shipped rig of that name, for the new file `file`. The rig is named after
/// the new file. A file that the text names becomes the name of a shipped file, or an absolute path. Histories and
/// protocols are not taken over: their paths stay relative to the new file. Fails as rig::read_rig() does.
[[nodiscard]] Result<std::string> copy_rig_text(const std::string& given, const std::string& file);

}  // namespace gyrotherm::app
