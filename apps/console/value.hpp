// SPDX-License-Identifier: Apache-2.0
/// What the value of an option, or a word after a command, stands for: so it is called in help and manual, and a shell
/// completes it accordingly. An option says it by ->type_name(value::kRig).
#pragma once

#include <string_view>
#include <vector>

#include "core/shipped.hpp"

namespace gyrotherm::app {

namespace value {
inline constexpr const char *kProfile = "PROFILE", *kRig = "RIG", *kMap = "MAP", *kGyro = "GYRO", *kRecord = "RECORD",
                            *kRecordOrFolder = "RECORD|FOLDER", *kModel = "MODEL", *kTable = "TABLE", *kToml = "TOML",
                            *kPem = "PEM", *kCode = "SOURCE", *kFile = "FILE", *kFolder = "FOLDER";
}  // namespace value

/// What a shell completes a value with.
struct ValueKind {
  std::string_view name;
  const ShippedKind* shipped;             ///< names of shipped files, or null
  std::vector<std::string_view> endings;  ///< of files, like "db"; empty: every file
  bool is_folder = false;                 ///< folders alone
};

/// The kind of that name, or null if its values are no files.
[[nodiscard]] const ValueKind* value_kind(std::string_view name);

}  // namespace gyrotherm::app
