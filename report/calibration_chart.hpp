// SPDX-License-Identifier: Apache-2.0
/// What a figure of the page needs to be enlarged and to have a cursor: its values as data, and the script that draws
/// them with dygraphs.
#pragma once

#include <cstddef>
#include <string>

#include "report/document.hpp"

namespace gyrotherm::report {

/// Whether dygraphs draws it as it is meant: x rises along each line, and no axis is logarithmic.
[[nodiscard]] bool can_be_enlarged(const FigureData& figure);

/// The values as JSON on one line, of at most `most_points` a line, thinned to the least and the greatest of each
/// stretch; no character of it ends a script element.
[[nodiscard]] std::string chart_data(const FigureData& figure, Language language, std::size_t most_points);

/// The script of the page, with dygraphs and the notice that its licence asks for.
[[nodiscard]] std::string chart_script();

}  // namespace gyrotherm::report
