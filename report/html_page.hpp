// SPDX-License-Identifier: Apache-2.0
/// A page of HTML as this program makes them: self-contained, without script or network, made to be printed too.
#pragma once

#include <string>

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

}  // namespace gyrotherm::report
