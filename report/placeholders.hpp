// SPDX-License-Identifier: Apache-2.0
/// Texts that people copied from an example and did not replace by their own.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/calibration.hpp"

namespace gyrotherm::report {

/// Whether a text is unfinished ("…", "...", "TODO", "TBD", "XXX"), an address of the domains reserved for examples
/// (RFC 2606), or one of the examples of docs/calibration-report.md that nobody's own text can be.
[[nodiscard]] bool is_placeholder(std::string_view text);

/// Returns the placeholders that a report has, each with the key that it came from:
/// `laboratory.toml: traceability.en, which is "Temperatures are … through …", a text of an example`.
[[nodiscard]] std::vector<std::string> placeholders_in(const CalibrationReport& report);

}  // namespace gyrotherm::report
