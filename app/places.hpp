// SPDX-License-Identifier: Apache-2.0
/// Where the shipped profiles are, and where a record goes that nobody named.
#pragma once

#include <string>

namespace gyrotherm::app {

/// "profiles/rigs/virtual.toml" as the user would write it if it is there, else the copy that was built or installed
/// with the program.
[[nodiscard]] std::string shipped(const std::string& path);

/// "short rate" → "short rate.db": a plain name in the working folder, whatever the profile's name is: what could lead
/// elsewhere, hide the file or steer a terminal becomes "_".
[[nodiscard]] std::string record_named_after(const std::string& profile_name);

}  // namespace gyrotherm::app
