// SPDX-License-Identifier: Apache-2.0
/// The policy of a site: rules that hold for all rigs of a machine, in one TOML file that only its administrator
/// writes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::app {

inline constexpr const char* kPolicySchema = "gyrotherm-policy/1";
inline constexpr const char* kPolicyFile = "/etc/gyrotherm/policy.toml";
/// Environment variable with the path of a policy that replaces kPolicyFile.
inline constexpr const char* kPolicyVariable = "GYROTHERM_POLICY";

/// Rules for programs that the site has not released.
enum class Unreleased { marked, refused };

/// The table [releases] of a policy.
struct ReleasePolicy {
  std::string register_folder;  ///< register of released programs (program_register.hpp)
  std::string trusted;          ///< PEM file with the certificates of those who release
  Unreleased unreleased = Unreleased::marked;
};

struct SitePolicy {
  std::string file;
  std::optional<ReleasePolicy> releases{};
};

/// Parses a policy. Paths in it are relative to the folder of `file`. Fails with bad_file and lists every error.
[[nodiscard]] Result<SitePolicy> parse_policy(std::string_view text, const std::string& file);

/// Reads the policy of this machine; nothing if it has none. Fails with bad_file if it is invalid, or if the variable
/// names a file that does not exist.
[[nodiscard]] Result<std::optional<SitePolicy>> read_policy();

}  // namespace gyrotherm::app
