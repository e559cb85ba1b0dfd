// SPDX-License-Identifier: Apache-2.0
/// The texts of the calibration report in each language, in one table, and the formats of numbers and days in each
/// language.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "report/calibration.hpp"
#include "report/plot/language.hpp"

namespace gyrotherm::report {

using plot::Language;
/// Returns "en" or "de".
[[nodiscard]] const char* code(Language language);

/// Returns the text of a key; asserts that the table has it. calibration_from_json() refuses reports with
/// unknown keys. Keys with a dot belong to the document: "heading.results", "say.only_this_item".
[[nodiscard]] std::string_view translate(Language language, std::string_view key);

/// Returns the key of the text above a table of models, which depends on whether one of them is recommended.
[[nodiscard]] std::string_view models_text_key(const std::vector<ComparedModel>& models);
/// Returns true for a key that a report may use: the table has it, and it does not belong to the document.
[[nodiscard]] bool has_text(std::string_view key);
/// Returns all keys in the order of the table.
[[nodiscard]] std::vector<std::string_view> text_keys();

/// Returns the text of a key with each {} replaced by a value. Asserts that the table has the key.
template <class... Values>
[[nodiscard]] std::string sentence(Language language, std::string_view key, const Values&... values) {
  return fmt::vformat(fmt::string_view(translate(language, key)), fmt::make_format_args(values...));
}

/// Returns the text in this language if present, otherwise the text in the other language.
[[nodiscard]] const std::string& text_in(Language language, const Texts& texts);

/// Formats a value rounded to two digits of U (GUM 7.2.6), in groups of three: "0.002 000 ± 0.000 061", German "0,002
/// 000 ± 0,000 061". Four digits are not split, spaces are narrow and non-breaking, minus is U+2212. A very small or
/// very large value is written with a power of ten: "(2.000 ± 0.061) × 10⁻⁹". Without U, or with U = 0, the value has
/// at most four significant digits, and an integer has all of its digits. An unknown value is "–". The result
/// does not contain k.
[[nodiscard]] std::string format(Language language, const ReportedValue& value);
/// Formats a result like format(). Without U, a result that is not an integer has four significant digits with trailing
/// zeros, like the other rows of its column.
[[nodiscard]] std::string format_result(Language language, const ReportedValue& value);
/// Value and U of format() as separate texts with the same number of decimals; `expanded` is empty without U.
struct FormattedValue {
  std::string value, expanded;
};
[[nodiscard]] FormattedValue format_parts(Language language, const ReportedValue& value);

/// Formats the value of a comparison like format(), with as many further digits as the printed numbers need to give the
/// verdict: "0.000 99 ± 0.007 10" for a value below the limit 0.001.
[[nodiscard]] std::string format_compared(Language language, const Conformity& conformity);

/// Formats a number with fixed decimals in groups of three; "–" if it is not finite.
[[nodiscard]] std::string format_number(Language language, double value, int decimals);
/// Formats a number with significant digits in groups of three, with a power of ten if the number is very small
/// or very large; "–" if it is not finite.
[[nodiscard]] std::string format_significant(Language language, double value, int digits);
/// Formats an exact number, or one without U: at most `digits` significant digits without trailing zeros; an integer
/// with all of its digits.
[[nodiscard]] std::string format_plain(Language language, double value, int digits = 4);
/// Formats a probability: "98.2 %", "> 99.9 %", "< 0.1 %"; "–" if unknown.
[[nodiscard]] std::string format_probability(Language language, double probability);

/// Formats "2026-11-25" as "25 November 2026" or "25. November 2026"; returns any other text unchanged.
[[nodiscard]] std::string format_day(Language language, std::string_view day);
/// Formats "2026-11-25T14:03:07Z" as "25 November 2026, 14:03:07 UTC"; returns any other text unchanged.
[[nodiscard]] std::string format_instant(Language language, std::string_view utc);

/// Formats a unit for print: "°/h/K" becomes "°/(h·K)", and "1" becomes empty. A word joiner (U+2060) after the slash
/// prevents a line break there.
[[nodiscard]] std::string format_unit(std::string_view unit);
/// Returns "0.012 K", or "0.0100°" without a blank for an angle in °, ′ or ″ (SI Brochure, 5.4.3).
[[nodiscard]] std::string append_unit(std::string_view number, std::string_view unit);
/// Returns the unit of a change of the bias per `unit`: "1" for °/h, "°/h" for "1", "°/h/K" for K, and "°/h/(m/s)" for
/// a unit with several factors.
[[nodiscard]] std::string sensitivity_unit(std::string_view unit);
/// Removes all word joiners, for a text that is never broken.
[[nodiscard]] std::string remove_word_joiners(std::string text);
/// Returns "Bias / (°/h)" or "Temperature / °C", with no line break after the slash; only the name if dimensionless.
[[nodiscard]] std::string name_with_unit(std::string_view name, std::string_view unit);

}  // namespace gyrotherm::report
