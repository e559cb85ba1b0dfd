// SPDX-License-Identifier: Apache-2.0
/// Texts that people copied from an example and did not replace by their own.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "report/calibration.hpp"

namespace gyrotherm::report {

/// Returns true for an unfinished text ("…", "...", "todo", "tbd", "fixme", "xxx"), an address in the domains reserved
/// for examples (RFC 2606), and the names and sentences of the examples in docs/calibration-report.md.
[[nodiscard]] bool is_placeholder(std::string_view text);

/// Returns the placeholders that a report has, each with the key that it came from:
/// `laboratory.toml: traceability.en, which is "Temperatures are … through …", a text of an example`.
[[nodiscard]] std::vector<std::string> placeholders_in(const CalibrationReport& report);

}  // namespace gyrotherm::report
