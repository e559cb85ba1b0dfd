// SPDX-License-Identifier: Apache-2.0
/// Numbers in the cells of a text table as people and instruments write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::exchange {

/// The style in which a table writes its numbers.
struct NumberStyle {
  char decimal = '.';
  char thousands = 0;                ///< 0: none
  std::vector<std::string> units{};  ///< allowed behind a number

  /// Returns the number as record::number_in() reads it: with a decimal point, without marks of thousands, with "-" for
  /// U+2212, and without its unit. The text itself where it is that already; an empty one if it cannot be one, as with
  /// a mark of thousands in a place where none belongs. The view is good until `changed` is.
  [[nodiscard]] std::string_view normalised(std::string_view text, std::string& changed) const;
};

/// U+2212 and the en dash, by which spreadsheets write a minus.
inline constexpr std::string_view kMinusSign = "\xE2\x88\x92", kEnDash = "\xE2\x80\x93";

/// Returns true if each mark of thousands parts three digits from those before: "1,234,567.8".
[[nodiscard]] bool has_good_thousands(std::string_view number, char thousands, char decimal);

/// Returns the text behind a number at the front of a cell: "°C" in "20.5 °C". Empty without a number or such a text.
[[nodiscard]] std::string_view unit_behind_number(std::string_view cell);

}  // namespace gyrotherm::exchange
