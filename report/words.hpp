// SPDX-License-Identifier: Apache-2.0
/// The words of the calibration report in each of its languages, in one table, and numbers and days as each language
/// writes them.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "report/calibration.hpp"

namespace gyrotherm::report {

enum class Language { english, german };
/// "en", "de".
[[nodiscard]] const char* code(Language language);

/// What a key is called; asserts that it is in the table. Keys of a report that are nobody's words are refused by
/// calibration_from_json already. Keys with a dot are the document's own: "heading.results", "say.only_this_item".
[[nodiscard]] std::string_view word(Language language, std::string_view key);

/// The key of what is said above a table of models: whether one of them is recommended.
[[nodiscard]] std::string_view say_of_models(const std::vector<ComparedModel>& models);
/// Whether a report may use it: it is in the table, and not one of the document's own.
[[nodiscard]] bool has_word(std::string_view key);
/// All keys of the table, in its order.
[[nodiscard]] std::vector<std::string_view> word_keys();

/// A sentence of the table with its places {} filled. Asserts that the key is there.
template <class... Values>
[[nodiscard]] std::string sentence(Language language, std::string_view key, const Values&... values) {
  return fmt::vformat(fmt::string_view(word(language, key)), fmt::make_format_args(values...));
}

/// In that language if it is there, else in the other.
[[nodiscard]] const std::string& in(Language language, const Texts& texts);

/// A value rounded to its uncertainty, two digits of U (GUM 7.2.6), in groups of three: "0.002 000 ± 0.000 061", German
/// "0,002 000 ± 0,000 061"; four digits stay together, spaces are narrow and do not break, minus is U+2212. Far from 1
/// it is "(2.000 ± 0.061) × 10⁻⁹". Where U is not known or 0 the value has four significant digits at most, and a whole
/// number all of them. "–" where the value is not known. k is for the caller to say.
[[nodiscard]] std::string format(Language language, const ReportedValue& value);
/// The two parts of it, of the same decimals; `expanded` is empty where there is none.
struct FormattedValue {
  std::string value, expanded;
};
[[nodiscard]] FormattedValue format_parts(Language language, const ReportedValue& value);

/// Fixed decimals, grouped; "–" of what is not finite.
[[nodiscard]] std::string format_number(Language language, double value, int decimals);
/// Significant digits, grouped; powers of ten where it is far from 1; "–" of what is not finite.
[[nodiscard]] std::string format_significant(Language language, double value, int digits);
/// What is exact, or has no U: four significant digits at most without zeros at the end, whole numbers as they are.
[[nodiscard]] std::string format_plain(Language language, double value);
/// A probability: "98.2 %", "> 99.9 %", "< 0.1 %"; "–" where it is not known.
[[nodiscard]] std::string format_probability(Language language, double probability);

/// "25 November 2026", "25. November 2026" of "2026-11-25"; what is no day comes back as it is.
[[nodiscard]] std::string format_day(Language language, std::string_view day);
/// "25 November 2026, 14:03:07 UTC" of "2026-11-25T14:03:07Z"; what is no instant comes back as it is.
[[nodiscard]] std::string format_instant(Language language, std::string_view utc);

/// A unit as it is printed: "°/(h·K)" of "°/h/K"; empty of "1".
[[nodiscard]] std::string format_unit(std::string_view unit);
/// "Bias / (°/h)", "Temperature / °C", and the name alone of a mere number; no line
/// breaks behind the stroke.
[[nodiscard]] std::string with_unit(std::string_view name, std::string_view unit);

}  // namespace gyrotherm::report
