// SPDX-License-Identifier: Apache-2.0
/// Numbers in reports and on the terminal: decimals, significant digits, and values with their uncertainty.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm {

/// Formats a number with fixed decimals and a true minus sign: decimal(0.00214, 4) is "0.0021". NaN is "–", and zero is
/// never negative.
[[nodiscard]] std::string decimal(double value, int digits);

/// Returns the exponent, as a superscript: "⁻⁵".
[[nodiscard]] std::string superscript(int exponent);

/// Formats a number with three significant digits: 1.23e-05 is "1.23 × 10⁻⁵" and 4.84 is "4.84".
[[nodiscard]] std::string format_significant(double value);

/// Formats a number with so many significant digits, without a power of ten from 0.00001 to 999999. Digits before the
/// decimal point are never left out: 12345 with 3 digits is "12345".
[[nodiscard]] std::string format_digits(double value, int digits);

/// Formats a value and its uncertainty, both rounded to the second significant digit of the uncertainty: "1.20 ± 0.15",
/// "1100 ± 84", "56800 ± 1200". Without an uncertainty, formats the value like format_significant().
[[nodiscard]] std::string format_with_error(double value, double error);

/// Returns the number of decimals down to the second significant digit of a positive uncertainty, at least 0.
[[nodiscard]] int decimals_for(double error);

/// Replaces the hyphens that begin a negative number by minus signs: "hold −20 °C". Leaves those in dates, names and
/// ranges unchanged.
[[nodiscard]] std::string with_minus_signs(std::string_view text);

/// Formats an uncertainty to its second digit: "0.000057".
[[nodiscard]] std::string format_error(double error);

}  // namespace gyrotherm
