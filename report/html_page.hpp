// SPDX-License-Identifier: Apache-2.0
/// A page of HTML and its tables: self-contained, without script or network, made to be printed too.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::report {

/// All but `body` is plain text.
struct HtmlPage {
  std::string title;  ///< of the window
  std::string kind;   ///< above the heading
  std::string heading;
  std::string subtitle = {};  ///< empty: none
  bool simulated{};           ///< the page says so at its top, and in print on every sheet
  std::string body;           ///< HTML
  std::string footer = {};
};

[[nodiscard]] std::string html_of(const HtmlPage& page);

/// Cells are HTML already: text that comes from data must have passed escaped().
struct HtmlTable {
  std::string caption = {};
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows = {};  ///< each as long as the header
  std::size_t text_columns = 1;  ///< the first ones are text, set left; the rest are numbers, set right
  std::string style = {};        ///< a further CSS class
};

[[nodiscard]] std::string html_of(const HtmlTable& table);

/// Returns a text as a string of CSS: all but letters and digits by their code, so that none of it is read as CSS or
/// HTML.
[[nodiscard]] std::string css_string(std::string_view text);

/// Returns "page {} of {}" with CSS counters in its places.
[[nodiscard]] std::string page_counter(const std::string& page_of);

}  // namespace gyrotherm::report
