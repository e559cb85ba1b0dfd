// SPDX-License-Identifier: Apache-2.0
/// Units and numbers in the notation of the Digital System of Units (D-SI 2.2, by PTB): "\degree\per\hour".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "report/calibration.hpp"

namespace gyrotherm::report {

/// Converts a unit to D-SI: "°/h" → "\degree\per\hour", "(°/h)/(K/min)" → "\degree\minute\hour\tothe{-1}\kelvin
/// \tothe{-1}". D-SI permits one \per in a unit, and everything after the \per is in the denominator. A unit with two
/// factors in its denominator is written with negative exponents, which every reader interprets in the same way.
/// Returns nothing for an unknown unit.
[[nodiscard]] std::optional<std::string> dsi_unit(std::string_view unit);

/// The parts of a value that D-SI can express.
enum class Certainty { nothing, value, with_normal_u, with_students_u };
/// Returns the known parts of a value. A k below 1 or a negative U counts as unknown.
[[nodiscard]] Certainty classify_certainty(const ReportedValue& value);

/// Formats a finite value. A value with U is rounded to the fourth significant digit of U, two digits more than
/// are printed in the report; a value without U is exact.
[[nodiscard]] std::string dsi_value(const ReportedValue& value);
/// Formats U with four significant digits, rounded up.
[[nodiscard]] std::string dsi_expanded(const ReportedValue& value);
/// Formats k without an exponent, because D-SI does not permit one here.
[[nodiscard]] std::string dsi_coverage_factor(const ReportedValue& value);
/// Formats a finite number exactly: reading the text gives the same double.
[[nodiscard]] std::string dsi_number(double number);

}  // namespace gyrotherm::report
