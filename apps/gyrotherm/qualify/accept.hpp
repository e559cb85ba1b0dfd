// SPDX-License-Identifier: Apache-2.0
/// The limits that a profile sets on the figures of the report.
#pragma once

#include <string>

#include "core/result.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::app {

/// The [accept] table of a profile names figures of the report alone; asked before anything moves. `file` is the
/// profile's. Fails with bad_file.
[[nodiscard]] Result<void> check_accept(const profile::Profile& profile, const std::string& file);

}  // namespace gyrotherm::app
