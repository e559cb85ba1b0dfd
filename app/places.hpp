/// Where the shipped profiles are.
#pragma once

#include <string>

namespace gyrotherm {

/// "profiles/rigs/virtual.toml" as the user would write it if it is there, else the copy that was built or installed
/// with the program.
[[nodiscard]] std::string shipped(const std::string& path);

}  // namespace gyrotherm
