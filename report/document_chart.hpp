// SPDX-License-Identifier: Apache-2.0
/// Figures of the page that can be enlarged and have a cursor: their values as data, and dygraphs, which draws them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "report/document.hpp"

namespace gyrotherm::report {

/// Returns true if dygraphs can draw the figure: x rises along each line, and no axis is logarithmic.
[[nodiscard]] bool can_be_enlarged(const FigureData& figure);

/// Returns the values as JSON on one line, of at most `most_points` a line, thinned to the least and the greatest of
/// each stretch; no character of it ends a script element.
[[nodiscard]] std::string chart_data(const FigureData& figure, Language language, std::size_t most_points);

/// Returns the script of the page, with dygraphs and the notice that its licence asks for.
[[nodiscard]] std::string chart_script();

// The build takes dygraphs from its Debian package; the repository has no file of it.

/// Returns its script, which makes the global name Dygraph. It ends no script element.
[[nodiscard]] std::string_view dygraphs_script();
/// Returns its style sheet.
[[nodiscard]] std::string_view dygraphs_style();

}  // namespace gyrotherm::report
