// SPDX-License-Identifier: Apache-2.0
/// Reads the rows of a foreign text table, as its map says, with numbers as people and instruments write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/foreign_row.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// The style in which a table writes its numbers.
struct NumberStyle {
  char decimal = '.';
  char thousands = 0;                ///< 0: none
  std::vector<std::string> units{};  ///< allowed behind a number

  /// Returns the number as record::number_in() reads it: with a decimal point, without marks of thousands, with "-" for
  /// U+2212, and without its unit. Returns the text itself if it has that form already, and an empty text if it cannot
  /// be a number, as with a mark of thousands at a wrong position. The view is valid until `changed` changes.
  [[nodiscard]] std::string_view normalised(std::string_view text, std::string& changed) const;
};

/// U+2212 and the en dash, which spreadsheets write for a minus.
inline constexpr std::string_view kMinusSign = "\xE2\x88\x92", kEnDash = "\xE2\x80\x93";

/// Returns true if each mark of thousands parts three digits from those before: "1,234,567.8".
[[nodiscard]] bool has_good_thousands(std::string_view number, char thousands, char decimal);

/// Returns the text behind a number at the front of a cell: "°C" in "20.5 °C". Returns an empty text if the cell has no
/// number or no text behind it.
[[nodiscard]] std::string_view unit_behind_number(std::string_view cell);

/// Hands on every row of a table. Lines end with LF or CRLF and are in UTF-8 or, with a byte order mark, in UTF-16. A
/// header that is not UTF-8 is taken for Latin-1. Ignores empty lines, a first line "sep=;" as spreadsheets write it,
/// and empty fields at the end of a row beyond those of the header. Reports a last line without an end, and leaves it
/// out if its last number has fewer decimals than those before.
///
/// Fails with bad_file at the first error, as `file:line:column: what, what was expected`; also if there is no row, or
/// a line has more than record::kLongestLine bytes or record::kMostFields fields. If the map leaves out damaged lines,
/// counts unreadable lines instead, and fails if they outnumber the rows. Fails as `take` does.
[[nodiscard]] Result<Findings> read_text_table(Bytes bytes, const ImportMap& map, const TakeRow& take);

}  // namespace gyrotherm::exchange
