// SPDX-License-Identifier: Apache-2.0
/// The dygraphs library, as its Debian package has it when this program is built; no file of it is in the repository.
#pragma once

#include <string_view>

namespace gyrotherm::report {

/// Its script, which makes the global name Dygraph. It ends no script element.
[[nodiscard]] std::string_view dygraphs_script();
/// Its style sheet.
[[nodiscard]] std::string_view dygraphs_style();

}  // namespace gyrotherm::report
