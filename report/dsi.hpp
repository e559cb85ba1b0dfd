// SPDX-License-Identifier: Apache-2.0
/// Units and numbers as the Digital System of Units writes them (D-SI 2.2, by PTB): "\degree\per\hour".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "report/calibration.hpp"

namespace gyrotherm::report {

/// A unit in D-SI's words: "°/h" → "\degree\per\hour", "(°/h)/(K/min)" → "\degree\minute\hour\tothe{-1}\kelvin
/// \tothe{-1}". D-SI has one \per in a unit at most, and all after it is below the line; where two units are below the
/// line, both have negative exponents, so that it is read alike by those who do not know this. Nothing of a unit that
/// it has no words for.
[[nodiscard]] std::optional<std::string> dsi_unit(std::string_view unit);

/// How much of a value is known, as D-SI can say it.
enum class Certainty { nothing, value, with_normal_u, with_students_u };
/// A k below 1 or a negative U is none.
[[nodiscard]] Certainty certainty_of(const ReportedValue& value);

/// A finite value; with U rounded to the fourth significant digit of U, two more than U is stated with, else exact.
[[nodiscard]] std::string dsi_value(const ReportedValue& value);
/// U, four significant digits, rounded up.
[[nodiscard]] std::string dsi_expanded(const ReportedValue& value);
/// k, without a power of ten, which D-SI does not allow here.
[[nodiscard]] std::string dsi_coverage_factor(const ReportedValue& value);
/// Any finite number, exact: it is read back to the same double.
[[nodiscard]] std::string dsi_number(double number);

}  // namespace gyrotherm::report
