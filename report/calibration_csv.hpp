// SPDX-License-Identifier: Apache-2.0
/// The results of a calibration report as one table for other programs.
#pragma once

#include <string>

#include "report/calibration.hpp"

namespace gyrotherm::report {

/// A line for each value of each result: what it is of, its keys as in calibration.json, then value, u, k, U = k·u,
/// degrees of freedom and unit. Numbers are exact, with a point; what is not known, or infinite, is empty. The first
/// column says "DRAFT", "SUPERSEDED", "SIMULATED", two of them, or nothing. RFC 4180: lines end in CR LF, a field with
/// a comma, a quote or a line break is quoted. A field of text that a spreadsheet would run as a formula begins with an
/// apostrophe.
[[nodiscard]] std::string csv_of(const CalibrationReport& report);

}  // namespace gyrotherm::report
