// SPDX-License-Identifier: Apache-2.0
/// German texts of the evidence that other parts of the program state in English.
#pragma once

#include <string>

namespace gyrotherm::app {

/// Returns the evidence with its known phrases in German, and a decimal comma in numbers with a unit. Paths, names, and
/// texts of instruments and of the operating system stay as they are. The evidence of earlier versions is known, too.
[[nodiscard]] std::string translate_evidence(std::string english);

}  // namespace gyrotherm::app
