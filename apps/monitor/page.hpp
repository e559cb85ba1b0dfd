// SPDX-License-Identifier: Apache-2.0
/// The files of the page, embedded by the build (cmake/embed.cmake), including dygraphs.
#pragma once

#include <string_view>

namespace gyrotherm::monitor {

[[nodiscard]] std::string_view page_html();
[[nodiscard]] std::string_view page_style();
[[nodiscard]] std::string_view page_icon();
[[nodiscard]] std::string_view page_script();
[[nodiscard]] std::string_view text_script();
[[nodiscard]] std::string_view views_script();
[[nodiscard]] std::string_view drawing_script();
[[nodiscard]] std::string_view chart_script();
[[nodiscard]] std::string_view control_script();
[[nodiscard]] std::string_view alarms_script();
[[nodiscard]] std::string_view site_script();
[[nodiscard]] std::string_view standard_script();
[[nodiscard]] std::string_view dygraphs_script();
[[nodiscard]] std::string_view dygraphs_style();
[[nodiscard]] std::string_view openapi_text();

}  // namespace gyrotherm::monitor
