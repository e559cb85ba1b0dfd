// SPDX-License-Identifier: Apache-2.0
/// Units and numbers in the notation of the Digital System of Units (D-SI 2.2, by PTB): "\degree\per\hour".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "report/calibration.hpp"

namespace gyrotherm::report {

/// Converts a unit to D-SI: "°/h" → "\degree\per\hour", "(°/h)/(K/min)" → "\degree\minute\hour\tothe{-1}\kelvin
/// \tothe{-1}". D-SI permits one \per per unit, and everything after it is in the denominator. A unit with two factors
/// in its denominator is therefore written with negative exponents, which are unambiguous for every reader. Returns
/// nothing for an unknown unit.
[[nodiscard]] std::optional<std::string> dsi_unit(std::string_view unit);

/// The parts of a value that D-SI can express.
enum class Certainty { nothing, value, with_normal_u, with_students_u };
/// Returns the known parts of a value. A k below 1 or a negative U counts as unknown.
[[nodiscard]] Certainty classify_certainty(const ReportedValue& value);

/// Returns a finite value. With U it is rounded to the fourth significant digit of U, two more than U is stated with;
/// without U it is exact.
[[nodiscard]] std::string dsi_value(const ReportedValue& value);
/// Returns U with four significant digits, rounded up.
[[nodiscard]] std::string dsi_expanded(const ReportedValue& value);
/// Returns k without an exponent, which D-SI does not permit here.
[[nodiscard]] std::string dsi_coverage_factor(const ReportedValue& value);
/// Returns a finite number exactly: reading it back gives the same double.
[[nodiscard]] std::string dsi_number(double number);

}  // namespace gyrotherm::report
