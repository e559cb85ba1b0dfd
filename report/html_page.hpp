// SPDX-License-Identifier: Apache-2.0
/// HTML pages and tables: self-contained, without script or network access, suitable for printing.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::report {

/// Contents of a page. All members except `body` are plain text.
struct HtmlPage {
  std::string title;  ///< window title
  /// Type of the page, printed above the heading.
  std::string kind;
  std::string heading;
  std::string subtitle = {};
  /// Marks the page as simulated data, at its top and on each printed sheet.
  bool simulated{};
  std::string body;  ///< HTML
  std::string footer = {};
  std::string language = "en";  ///< language of the texts, BCP 47
};

[[nodiscard]] std::string to_html(const HtmlPage& page);

/// A table. Cells are HTML: text from data must have passed escaped().
struct HtmlTable {
  std::string caption = {};
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows = {};  ///< each as long as the header
  /// Number of leading columns with text, aligned left; the others have numbers, aligned right.
  std::size_t text_columns = 1;
  std::string style = {};  ///< additional CSS class
};

[[nodiscard]] std::string to_html(const HtmlTable& table);

/// Returns a text as a CSS string. Every character except letters and digits is escaped as its code, so nothing is
/// interpreted as CSS or HTML.
[[nodiscard]] std::string css_string(std::string_view text);

/// Returns "page {} of {}" with CSS counters instead of {}.
[[nodiscard]] std::string page_counter(const std::string& page_of);

}  // namespace gyrotherm::report
