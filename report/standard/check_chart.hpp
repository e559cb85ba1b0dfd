// SPDX-License-Identifier: Apache-2.0
/// The control charts of a history of check runs as one figure.
#pragma once

#include <string>
#include <vector>

#include "report/plot/language.hpp"
#include "report/standard/check_view.hpp"

namespace gyrotherm::standard {

struct ChartStyle {
  plot::Language language = plot::Language::english;
  double width_px = 760;
};

/// Returns the control charts as one SVG figure with a title and a description of its standing. Every panel of a
/// virtual rig is marked as simulated. The history must have a check run.
[[nodiscard]] std::string to_svg(const CheckedStandard& standard, const ChartStyle& style);

/// A part of the charts that fits on a printed page.
struct ChartSheet {
  std::string svg;
  std::string caption;
};

/// Returns the same charts as several figures.
[[nodiscard]] std::vector<ChartSheet> to_svg_sheets(const CheckedStandard& standard, const ChartStyle& style);

/// Returns the standing in one sentence: in control, too few runs, or how many runs are out of control.
[[nodiscard]] std::string describe_standing(const CheckedStandard& standard, plot::Language language);

/// Returns the label of a plateau with a true minus sign.
[[nodiscard]] std::string shown_plateau(const std::string& plateau);

}  // namespace gyrotherm::standard
