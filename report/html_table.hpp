// SPDX-License-Identifier: Apache-2.0
/// A table of the page.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace gyrotherm::report {

/// Cells are HTML already: text that comes from data must have passed escaped().
struct HtmlTable {
  std::string caption = {};
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows = {};  ///< each as long as the header
  std::size_t text_columns = 1;  ///< the first ones are text, set left; the rest are numbers, set right
  std::string style = {};        ///< a further CSS class
};

[[nodiscard]] std::string html_of(const HtmlTable& table);

}  // namespace gyrotherm::report
