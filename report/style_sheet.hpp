// SPDX-License-Identifier: Apache-2.0
/// The look of the HTML report, on screen and in print.
#pragma once

#include <string>

namespace gyrotherm::report {

/// CSS without any reference to the outside. With `simulated`, every printed page says so in its margin and across
/// itself.
[[nodiscard]] std::string style_sheet(bool simulated);

}  // namespace gyrotherm::report
