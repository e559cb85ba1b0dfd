// SPDX-License-Identifier: Apache-2.0
/// The protocol of a validation: the requirements on an installed program and its rig, and the result of each.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "apps/gyrotherm/protocol_folder.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::app {

inline constexpr const char* kValidationSchema = "gyrotherm-validation/1";

enum class ValidationVerdict { passed, failed, not_applicable };
inline constexpr std::initializer_list<ValidationVerdict> kValidationVerdicts = {
    ValidationVerdict::passed, ValidationVerdict::failed, ValidationVerdict::not_applicable};
[[nodiscard]] inline const char* name(ValidationVerdict verdict) {
  return enumerator_text<ValidationVerdict::not_applicable>({"passed", "failed", "not applicable"}, verdict);
}

struct RequirementResult {
  std::string id;  ///< such as "OQ-3"
  /// Text of the requirement.
  std::string english, german;
  ValidationVerdict verdict{};
  /// Observed facts, or the reason of a failure.
  std::string evidence{};
  /// The evidence in German; empty in a protocol of an earlier version.
  std::string evidence_german{};
};

/// A program of the installation.
struct InstalledProgram {
  std::string name, sha256;
};

struct Validation {
  std::string rig, title, rig_file, rig_sha256;
  bool simulated{};     ///< the rig is virtual
  std::string version;  ///< the program's version
  std::string operator_name;
  std::string began, ended;  ///< UTC
  std::vector<InstalledProgram> programs{};
  std::vector<RequirementResult> results{};
};

/// Returns passed unless a requirement failed.
[[nodiscard]] ValidationVerdict overall_verdict(const Validation& validation);

[[nodiscard]] std::string to_json(const Validation& validation);
/// Parses a protocol. Fails with bad_file.
[[nodiscard]] Result<Validation> parse_validation(std::string_view json, const std::string& file);

/// Returns the kind of the protocol, with its page.
[[nodiscard]] ProtocolKind validation_protocol();

}  // namespace gyrotherm::app
