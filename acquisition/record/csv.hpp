// SPDX-License-Identifier: Apache-2.0
/// Text tables: a parser for one line, a reader for a numeric table that arrives in pieces, and the export of a record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::record {

// The parser for one line of a text table.

/// The largest line of any table in bytes, and its largest number of fields.
inline constexpr std::size_t kLongestLine = 65536;
inline constexpr std::size_t kMaxFields = 4096;

struct Field {
  std::string_view text;  ///< quotes and outer blanks removed
  std::size_t column{};   ///< first byte, from 1
  /// The field was quoted, and its text contains `""`, each of which represents one `"`.
  bool has_doubled_quotes{};
};

/// Returns the text of a field, with each doubled quote replaced by one quote.
[[nodiscard]] std::string unquote(const Field& field);

/// The reason why a line cannot be split.
struct LineFault {
  std::size_t column{};  ///< byte of the line, from 1
  std::string what;
};

/// Splits a line at `separator`. Fields may be in double quotes, in which `""` is a quote (RFC 4180), with blanks
/// around them. If the separator is a blank, several blanks are one separator, and blanks at either end are ignored.
/// Fails if a quote is not closed, if text follows a closing quote, or if there are more than kMaxFields.
[[nodiscard]] tl::expected<void, LineFault> split_line(std::string_view line, char separator,
                                                       std::vector<Field>& fields);

/// Returns the text without blanks, tabs and carriage returns at its start and end.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// Parses the whole text as a finite number with a decimal point and an optional sign. Returns nothing if it is not
/// one.
[[nodiscard]] std::optional<double> number_in(std::string_view text);

/// Reads a numeric text table that arrives in pieces. The table has optional comment lines that begin with #, a header,
/// and rows with fields separated by commas.
class LiveRows {
 public:
  /// Chooses the columns to read, and their order, from the header and the comments before it. The content of other
  /// columns is ignored.
  using Choose = std::function<Result<std::vector<std::size_t>>(const std::vector<std::string>& header,
                                                                const std::vector<std::string>& comments)>;
  /// Creates a reader. `source` is the first part of the position in each fault: "stdin" produces "stdin:12:3". Without
  /// `choose` all columns are read.
  explicit LiveRows(std::string source, Choose choose = {}) : source_(std::move(source)), choose_(std::move(choose)) {}

  /// Reads all complete lines and keeps an incomplete one for the next piece. Skips blank lines. Fails with bad_file at
  /// the first error: a row with more or fewer fields than the header, a field of a chosen column that is not a finite
  /// number, or a line longer than kLongestLine. Also fails as `choose` does. Rows before the error remain available.
  [[nodiscard]] Result<void> take(std::string_view piece);
  /// Reads the last line, which need not end with a newline. Fails as take() does, and if there was no header.
  [[nodiscard]] Result<void> finish();

  /// Returns the fields of the first line that is not a comment; empty before it arrives.
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  /// Returns the header indices of the columns that are read.
  [[nodiscard]] const std::vector<std::size_t>& columns() const { return columns_; }
  /// Returns the values of all rows since the last forget_rows(), row by row, columns().size() per row. An empty field
  /// is NaN.
  [[nodiscard]] const std::vector<double>& numbers() const { return numbers_; }
  /// Returns the line number of each of these rows, from 1.
  [[nodiscard]] const std::vector<std::size_t>& lines() const { return lines_; }
  void forget_rows() {
    numbers_.clear();
    lines_.clear();
  }

 private:
  Result<void> read_line(std::string_view line);
  Result<void> read_header();
  Result<void> read_row();
  [[nodiscard]] tl::unexpected<Fault> fault_at(std::size_t column, std::string what) const;

  std::string source_;
  Choose choose_;
  std::string rest_;    ///< beginning of an incomplete line
  std::size_t line_{};  ///< present line, from 1
  std::vector<Field> fields_;
  std::vector<std::string> comments_;
  std::vector<std::string> header_;
  std::vector<std::size_t> columns_;
  std::vector<double> numbers_;
  std::vector<std::size_t> lines_;
};

// The export of a record as a text table.

struct Record;
struct RunInfo;

/// Returns the record as text: comment lines with `#`, a header of names with units, and one row per sample. A missing
/// value is an empty field.
/// The comments identify the record ("SIMULATED" first if it is simulated). They also contain the constants that are
/// required to compute a bias from the numbers and a temperature from the readings: "axis u1.x: scale 0.1, earth rate
/// 10.04" (arcsec per pulse, or °/h per unit of a rate; Earth rate in °/h if the record has it), "thermometer A: offset
/// 0.01" (K), "thermometer A: polynomial 0 1.001". They name the thermometers of a unit's gradients and of its three
/// points: "unit u1: gradients A, B, C", "unit u1: three point A, C, shell".
/// If operators handle the unit during the profile, a further column contains its mounting (turned_at): the Earth rate
/// of a turned unit has the opposite sign. Fields are quoted as in RFC 4180, and lines end with LF. Numbers have the
/// fewest digits that read back to the same value.
[[nodiscard]] std::string to_csv(const Record& record);
/// The title of the column with the mounting.
inline constexpr std::string_view kTurnedTitle = "turned";
/// Writes the same text in pieces. The text of a record with many channels is larger than the record itself.
void write_csv(const Record& record, const std::function<void(std::string_view)>& sink);
/// Writes only the comments and the header, for a record that is still being written.
void write_csv_head(const RunInfo& info, bool finished, const std::function<void(std::string_view)>& sink);
/// Writes the rows after second `after`.
void write_csv_rows(const Record& record, std::int64_t after, const std::function<void(std::string_view)>& sink);

}  // namespace gyrotherm::record
