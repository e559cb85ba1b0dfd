// SPDX-License-Identifier: Apache-2.0
/// How a foreign text table is written, found out from its lines: what stands before its rows, how they are cut, and
/// how their numbers are written.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/cell_number.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

struct TableSample {
  std::string comment{};
  char separator = ',';
  bool header = true;      ///< the file has one that a map can name columns by
  std::size_t preamble{};  ///< lines before it
  std::size_t skip{};      ///< lines behind it, or before the first row, that are no rows
  NumberStyle style{};
  bool is_decimal_doubtful = false;              ///< "1,234" may be a thousand and some or one and a part
  std::vector<std::string> names{};              ///< of the columns; empty where the file names none
  std::vector<std::string> cell_units{};         ///< of each column, behind its numbers; empty: none
  std::vector<std::vector<std::string>> rows{};  ///< fields of those that can be read
  std::vector<std::string> missing{};            ///< fields among numbers that are none
  std::size_t damaged{};                         ///< lines that cannot be read
  std::size_t first_damaged{};                   ///< the number of the first

  /// The numbers of a column; fewer than half of its fields: none.
  [[nodiscard]] std::vector<double> numbers_of(std::size_t column) const;
  [[nodiscard]] std::optional<double> number_in_field(const std::string& field) const;
  /// Whether a map must call it by its number: it has no name, or one that another column has too.
  [[nodiscard]] bool is_called_by_number(std::size_t column) const;
  [[nodiscard]] std::string name_of(std::size_t column) const;
};

/// Looks at the first 100,000 lines, and 32 MiB, of a file. Fails with bad_file where it cannot be read, or is no table
/// of two columns or more.
[[nodiscard]] Result<TableSample> sample_table(Bytes bytes);

}  // namespace gyrotherm::exchange
