// SPDX-License-Identifier: Apache-2.0
/// Protection of a draft until its authorisation. sources.json names the files from which a draft was made, and the
/// SHA-256 of the calibration.json that the program wrote. The authorisation makes the report again from these files
/// and compares it with the draft.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::report {

inline constexpr const char* kSourcesFile = "sources.json";
inline constexpr const char* kSourcesSchema = "gyrotherm-sources/1";

/// The command that made a draft. Paths are relative to the folder of the draft.
struct DraftSources {
  std::string program_version{};
  std::string calibration_sha256{};  ///< digest of calibration.json as written
  std::string unit{};                ///< name in the rig; may be empty
  std::vector<std::string> records{};
  std::vector<std::string> models_left{}, models_found{};
  std::string folder_left{}, folder_found{};  ///< folders of models; may be empty
  std::string inputs{};
  std::string laboratory{}, order{}, check_standard{};
  bool unverified{};
};

/// Returns sources.json, ending in a newline. The text depends only on `sources`.
[[nodiscard]] std::string to_json(const DraftSources& sources);

/// Reads sources.json. Fails with bad_file on syntax errors, another schema or a missing key.
[[nodiscard]] Result<DraftSources> draft_sources_from_json(std::string_view json, const std::string& file);

/// Returns the keys in which two JSON documents differ, such as "conformity/0/verdict", in their order.
[[nodiscard]] Result<std::vector<std::string>> find_changed_keys(std::string_view before, std::string_view now);

/// Lists the contradictions within a report, without its sources: verdicts and probabilities that do not follow from
/// value, limit and decision rule; values that are in no table of results; limits that are not applied to a table; and
/// uncertainties that differ from their budget.
[[nodiscard]] std::vector<std::string> find_contradictions(const CalibrationReport& report);

}  // namespace gyrotherm::report
