// SPDX-License-Identifier: Apache-2.0
/// Finds out from the lines of a foreign text table how it is written: the lines before its rows, their separator, and
/// the style of their numbers.
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

/// The first rows of a table, with the way in which it is written.
struct TableSample {
  std::string comment{};
  char separator = ',';
  bool header = true;      ///< a map can name columns by it
  std::size_t preamble{};  ///< lines before the header
  std::size_t skip{};      ///< other lines before the first row
  NumberStyle style{};
  bool is_decimal_doubtful = false;              ///< "1,234" may be 1234 or 1.234
  std::vector<std::string> names{};              ///< per column; empty: unnamed
  std::vector<std::string> cell_units{};         ///< per column, behind its numbers
  std::vector<std::vector<std::string>> rows{};  ///< fields of readable rows
  std::vector<std::string> missing{};            ///< fields that mark missing numbers
  std::size_t damaged{};                         ///< unreadable lines
  std::size_t first_damaged{};                   ///< line number, from 1

  /// Returns the numbers of a column, or none if fewer than half of its fields are numbers.
  [[nodiscard]] std::vector<double> numbers_of(std::size_t column) const;
  [[nodiscard]] std::optional<double> number_in_field(const std::string& field) const;
  /// Returns true if a map must refer to a column by its number: its name is empty or not unique.
  [[nodiscard]] bool is_called_by_number(std::size_t column) const;
  [[nodiscard]] std::string name_of(std::size_t column) const;
  /// Returns the line of a map that names a column: "column = "T1"", or "column_number = 3" with its name behind; of a
  /// table without a header "column = 3". `key` takes the position of "column".
  [[nodiscard]] std::string reference(std::size_t column, const std::string& key = "column") const;
};

/// Returns a text of a foreign file in quotes, as TOML reads it, with control characters shown as text.
[[nodiscard]] std::string toml_text(std::string_view text);

/// Looks at the first 100,000 lines, and at most 32 MiB, of a file. Fails with bad_file if the file cannot be read or
/// is not a table of two columns or more.
[[nodiscard]] Result<TableSample> sample_table(Bytes bytes);

}  // namespace gyrotherm::exchange
