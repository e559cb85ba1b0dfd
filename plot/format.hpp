/// Numbers and text as a reader of the report sees them.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm {

/// Fixed decimals with a true minus sign; "–" for NaN, and never a negative zero: decimal(0.00214, 4) is "0.0021".
[[nodiscard]] std::string decimal(double value, int digits);

/// A bias or a residual in °/h, with four decimals as in the paper's tables.
[[nodiscard]] std::string bias_text(double deg_per_h);

/// A fraction in per cent with one decimal: percent(0.76404) is "76.4 %".
[[nodiscard]] std::string percent(double fraction);

/// Three significant digits: 1.23e-05 is "1.23 × 10⁻⁵" and 4.84 stays "4.84"; for certificates and tuned parameters.
[[nodiscard]] std::string significant(double value);

/// The label of a logarithmic axis: "0.02" and "500" near 1, "10⁻⁵" and "2 × 10⁻⁵" far from it.
[[nodiscard]] std::string digit_and_power(int digit, int exponent);

/// A value and its standard error, both to the second digit of the error: "0.00214 ± 0.00006". Without an error, as
/// significant() gives the value.
[[nodiscard]] std::string with_error(double value, double error);

/// A standard error alone, to its second digit: "0.000057".
[[nodiscard]] std::string error_text(double error);

/// A length of time in hours with two decimals: "18.67 h".
[[nodiscard]] std::string hours_text(double seconds);

/// Text made safe inside SVG and HTML, in elements and in attributes. Control characters, which XML forbids, are
/// dropped.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace gyrotherm
