// SPDX-License-Identifier: Apache-2.0
/// The folders in which a rig's runs and documents lie.
#pragma once

#include <string>
#include <vector>

namespace gyrotherm::site {

/// Those of the site file and the ones below them, to a depth of three; links are not followed. Any thread.
[[nodiscard]] std::vector<std::string> folders_below(const std::vector<std::string>& tops);

}  // namespace gyrotherm::site
