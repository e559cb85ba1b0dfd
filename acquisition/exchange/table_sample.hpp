// SPDX-License-Identifier: Apache-2.0
/// Detects the notation of a text table from its lines: the lines before its rows, their separator, and the style of
/// their numbers.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/text_table.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// The first rows of a table and its notation.
struct TableSample {
  std::string comment{};
  /// The comment lines without the beginning `comment`.
  std::vector<std::string> comments{};
  char separator = ',';
  bool header = true;      ///< the column names are usable
  std::size_t preamble{};  ///< lines before the header
  std::size_t skip{};      ///< other lines before the first row
  NumberStyle style{};
  bool is_decimal_doubtful = false;  ///< "1,234" may be 1234 or 1.234
  /// The name of each column; empty if it has none.
  std::vector<std::string> names{};
  /// The unit after the numbers of each column.
  std::vector<std::string> cell_units{};
  /// The unit of each column that a LabVIEW header or a line of units states; empty for other files.
  std::vector<std::string> header_units{};
  bool is_lvm = false;  ///< a LabVIEW measurement file
  /// The spacing of rows without a time, from the header.
  std::optional<double> spacing_s{};
  /// The fields of all readable rows.
  std::vector<std::vector<std::string>> rows{};
  /// The fields that mark missing numbers.
  std::vector<std::string> missing{};
  /// The number of unreadable lines, and the number of the first one, from 1.
  std::size_t damaged{};
  std::size_t first_damaged{};

  /// Returns the numbers of a column. Returns an empty vector if fewer than half of its fields are numbers.
  [[nodiscard]] std::vector<double> column_numbers(std::size_t column) const;
  [[nodiscard]] std::optional<double> number_in_field(const std::string& field) const;
  /// Returns true if a map must refer to a column by its number: its name is empty or not unique.
  [[nodiscard]] bool needs_column_number(std::size_t column) const;
  [[nodiscard]] std::string column_name(std::size_t column) const;
  /// Returns the line of a map that names a column: "column = "T1"", or "column_number = 3" with its name as a comment;
  /// for a table without a header "column = 3". `key` replaces "column".
  [[nodiscard]] std::string reference(std::size_t column, const std::string& key = "column") const;
};

/// Returns a text of a file in quotes for TOML, with control characters made visible.
[[nodiscard]] std::string toml_text(std::string_view text);

/// Reads the first 100,000 lines of a file, and at most 32 MiB. Fails with bad_file if the file cannot be read or is
/// not a table with at least two columns.
[[nodiscard]] Result<TableSample> sample_table(Bytes bytes);

}  // namespace gyrotherm::exchange
