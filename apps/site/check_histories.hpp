// SPDX-License-Identifier: Apache-2.0
/// Histories of check runs that records name, as control charts for the store (docs/check-standard.md).
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// The history that the rig file in a record names.
struct NamedHistory {
  std::vector<std::string> paths;  ///< beside the rig file, beside the record; the first that exists counts
  std::string rig;                 ///< name in the rig file
  bool simulated{};
  auto operator<=>(const NamedHistory&) const = default;
};

/// Returns the history that a record names; `paths` is empty if the rig has no check standard.
[[nodiscard]] NamedHistory name_history(const record::RunInfo& info, const std::string& record);
/// Returns the path that exists; empty if there is none.
[[nodiscard]] std::string find_path(const NamedHistory& named);

/// The arguments of add_check_standard().
struct CheckCharts {
  std::string history;  ///< SHA-256 of the first line
  std::string json;     ///< schema gyrotherm-control-charts/1
};

/// Reads a history and computes its charts. Returns nothing if it has no check run, or is of another rig than `named`.
/// Fails with bad_file if it is not an intact history, or has more than 16 MB.
[[nodiscard]] Result<std::optional<CheckCharts>> read_check_charts(const NamedHistory& named, const std::string& path);

}  // namespace gyrotherm::site
