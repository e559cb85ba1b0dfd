// SPDX-License-Identifier: Apache-2.0
/// A page of HTML as this program makes them: self-contained, without script or network, made to be printed too.
#pragma once

#include <string>
#include <string_view>

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

/// Returns a text as a string of CSS: all but letters and digits by their code, so that none of it is read as CSS or
/// HTML.
[[nodiscard]] std::string css_string(std::string_view text);

/// Returns "page {} of {}" with CSS counters in its places.
[[nodiscard]] std::string page_counter(const std::string& page_of);

}  // namespace gyrotherm::report
