// SPDX-License-Identifier: Apache-2.0
/// Figures of the page with zoom and cursor: their values as data, drawn by dygraphs.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "report/document.hpp"

namespace gyrotherm::report {

/// Returns true if dygraphs can draw the figure: x increases along each line, and both axes are linear.
[[nodiscard]] bool can_be_enlarged(const FigureData& figure);

/// Returns the values as JSON on one line. Each line of the figure is reduced to at most `most_points` points; the
/// minimum and maximum of each section are kept. `mark` is drawn across the figure, such as "SIMULATED"; it may be
/// empty. The JSON contains nothing that could end a script element.
[[nodiscard]] std::string chart_data(const FigureData& figure, Language language, std::size_t most_points,
                                     const std::string& mark);

/// Returns the script of the page: dygraphs with the notice required by its licence, and the code that calls it.
[[nodiscard]] std::string chart_script();

// The build takes dygraphs from its Debian package; the repository contains no file of it.

/// Returns the script of dygraphs, which defines the global name Dygraph. It does not end a script element.
[[nodiscard]] std::string_view dygraphs_script();
/// Returns the style sheet of dygraphs.
[[nodiscard]] std::string_view dygraphs_style();

}  // namespace gyrotherm::report
