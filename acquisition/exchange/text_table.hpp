// SPDX-License-Identifier: Apache-2.0
/// Reads the rows of a text table according to its map, with numbers in the notations of users and instruments.
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
  std::vector<std::string> units{};  ///< allowed after a number

  /// Returns the number in the notation of record::number_in(): with a decimal point, without thousands separators,
  /// with "-" for U+2212, and without its unit. Returns the text itself if it already has this form. Returns an empty
  /// text if it cannot be a number, for example if a thousands separator is at a wrong position. The view is valid
  /// until `changed` changes.
  [[nodiscard]] std::string_view normalise(std::string_view text, std::string& changed) const;
};

/// U+2212 and the en dash, which spreadsheets write as a minus sign.
inline constexpr std::string_view kMinusSign = "\xE2\x88\x92", kEnDash = "\xE2\x80\x93";

/// Returns whether the thousands separators divide the number into groups of three digits: "1,234,567.8".
[[nodiscard]] bool has_good_thousands(std::string_view number, char thousands, char decimal);

/// Returns the text after a number at the start of a cell: "°C" in "20.5 °C". Returns an empty text if the cell has no
/// number or no text after it.
[[nodiscard]] std::string_view unit_behind_number(std::string_view cell);

/// Passes on every row of a table. Lines end with LF or CRLF and are in UTF-8 or, with a byte order mark, in UTF-16. A
/// header that is not UTF-8 is read as Latin-1. Ignores empty lines, a first line "sep=;" of a spreadsheet, and empty
/// fields at the end of a row in excess of the header. Notes a last line without a line end, and skips it if its last
/// number has fewer decimals than the last numbers of all earlier rows.
///
/// Fails with bad_file at the first error, as `file:line:column: what, what was expected`; also if there is no row, or
/// a line has more than record::kLongestLine bytes or record::kMaxFields fields. If the map skips damaged lines,
/// counts unreadable lines instead, and fails if they outnumber the rows. Fails as `take` does.
[[nodiscard]] Result<Findings> read_text_table(Bytes bytes, const ImportMap& map, const TakeRow& take);

}  // namespace gyrotherm::exchange
