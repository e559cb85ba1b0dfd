// SPDX-License-Identifier: Apache-2.0
/// Histories of check runs that records name, as control charts for the store (docs/check-standard.md).
#pragma once

#include <optional>
#include <string>

#include "acquisition/record/check_history.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// The arguments of add_check_standard().
struct CheckCharts {
  std::string history;  ///< SHA-256 of the first line
  std::string json;     ///< schema gyrotherm-control-charts/1
};

/// Reads a history and computes its charts. Returns nothing if it has no check run, or is of another rig than `named`.
/// Fails with bad_file if it is not an intact history, or has more than 16 MB.
[[nodiscard]] Result<std::optional<CheckCharts>> read_check_charts(const record::NamedHistory& named,
                                                                   const std::string& path);

}  // namespace gyrotherm::site
