// SPDX-License-Identifier: Apache-2.0
/// Views of the check runs of a rig: text, JSON, and the control charts as SVG or as a page, in English and German.
#pragma once

#include <optional>
#include <string>

#include "analysis/assurance/diagnosis.hpp"
#include "analysis/assurance/history.hpp"
#include "report/words.hpp"

namespace gyrotherm::app {

/// A history with its charts, and the diagnosis if the last run is out of control.
struct CheckedStandard {
  std::string file;
  assurance::History history;
  assurance::Assessment assessment;
  std::optional<assurance::Diagnosis> diagnosis;
};

/// Returns the standing for a terminal: verdict, the charts that are out of control, and the diagnosis.
[[nodiscard]] std::string describe(const CheckedStandard& standard);
[[nodiscard]] std::string to_json(const CheckedStandard& standard);
/// Returns the control charts as one figure. Every panel of a virtual rig is marked as simulated.
[[nodiscard]] std::string to_svg(const CheckedStandard& standard, report::Language language);
/// Returns a page with the standing, the charts, all runs and all explanations.
[[nodiscard]] std::string to_html(const CheckedStandard& standard, report::Language language);

}  // namespace gyrotherm::app
