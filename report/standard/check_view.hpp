// SPDX-License-Identifier: Apache-2.0
/// A history of check runs with its charts and its diagnosis, and its views as text and JSON.
#pragma once

#include <optional>
#include <string>

#include "analysis/assurance/diagnosis.hpp"
#include "analysis/assurance/history.hpp"
#include "core/result.hpp"

namespace gyrotherm::standard {

/// A history with its charts, and the diagnosis if a run is out of control and not explained.
struct CheckedStandard {
  std::string file;
  assurance::History history;
  assurance::Assessment assessment;
  std::optional<assurance::Diagnosis> diagnosis;
};

/// Computes charts and diagnosis of a history.
[[nodiscard]] CheckedStandard assess_standard(assurance::History history, std::string file);
/// Parses a history and computes its charts and diagnosis. Fails like parse_history().
[[nodiscard]] Result<CheckedStandard> assess_standard(std::string_view text, const std::string& file);

/// Returns the standing for a terminal: verdict, the charts that are out of control, and the diagnosis.
[[nodiscard]] std::string describe(const CheckedStandard& standard);
[[nodiscard]] std::string to_json(const CheckedStandard& standard);

}  // namespace gyrotherm::standard
