// SPDX-License-Identifier: Apache-2.0
/// Text tables: one line cut into fields, a table of numbers that arrives in pieces, and a record as a table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::record {

// One line of a text table, cut into fields.

inline constexpr std::size_t kLongestLine = 65536;  ///< bytes of a line of any table
inline constexpr std::size_t kMostFields = 4096;    ///< … and its fields

struct Field {
  std::string_view text;      ///< trimmed of blanks, without its quotes
  std::size_t column{};       ///< where it begins, in bytes from 1
  bool has_doubled_quotes{};  ///< it stood in quotes, and each `""` in the text is one `"`
};

/// The text as it is meant: with doubled quotes made one.
[[nodiscard]] std::string unquoted(const Field& field);

/// Cuts at `separator`; fields may stand in double quotes, in which `""` is a quote (RFC 4180), with blanks around
/// them. With a blank as separator any run of blanks is one, and blanks at either end are none. Fails with bad_file
/// (`where` is the column alone) if a quote is not closed or followed by text, or where there are more than
/// kMostFields.
[[nodiscard]] Result<void> cut(std::string_view line, char separator, std::vector<Field>& fields);

[[nodiscard]] std::string_view trimmed(std::string_view text);

/// The finite number that the whole text is, with a decimal point; a sign may stand before it.
[[nodiscard]] std::optional<double> number_in(std::string_view text);

// A text table of numbers that arrives in pieces: perhaps comments, lines that begin with #; a header; then rows,
// fields between commas.

class LiveRows {
 public:
  /// Which columns are read, and in what order, by the header and by the comments before it. What the others hold is
  /// nobody's business.
  using Choose = std::function<Result<std::vector<std::size_t>>(const std::vector<std::string>& header,
                                                                const std::vector<std::string>& comments)>;
  /// `source` begins the place of each mistake: "stdin" makes "stdin:12:3". Without `choose` all columns are read.
  explicit LiveRows(std::string source, Choose choose = {}) : source_(std::move(source)), choose_(std::move(choose)) {}

  /// Reads the lines that are whole by now; what is left waits for the next piece. Blank lines are passed over. Fails
  /// with bad_file at the first mistake: a row of more or fewer fields than the header, a field of a column that is
  /// read and is no finite number, a line longer than kLongestLine; or as `choose` does. The rows before it are there.
  [[nodiscard]] Result<void> take(std::string_view piece);
  /// Reads the last line, which need not end. Fails like take, and if not even a header has come.
  [[nodiscard]] Result<void> finish();

  /// The fields of the first line that is no comment; none until it has come.
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  /// The columns that are read: places in the header.
  [[nodiscard]] const std::vector<std::size_t>& columns() const { return columns_; }
  /// The rows read since the last forget_rows, one after the other, each as long as columns(). An empty field is NaN.
  [[nodiscard]] const std::vector<double>& numbers() const { return numbers_; }
  /// The line of each of these rows, from 1.
  [[nodiscard]] const std::vector<std::size_t>& lines() const { return lines_; }
  void forget_rows() {
    numbers_.clear();
    lines_.clear();
  }

 private:
  Result<void> read_line(std::string_view line);
  Result<void> read_header();
  Result<void> read_row();
  [[nodiscard]] tl::unexpected<Fault> mistake(std::size_t column, std::string what) const;

  std::string source_;
  Choose choose_;
  std::string rest_;    ///< the beginning of a line whose end has not come
  std::size_t line_{};  ///< the one being read, from 1
  std::vector<Field> fields_;
  std::vector<std::string> comments_;
  std::vector<std::string> header_;
  std::vector<std::size_t> columns_;
  std::vector<double> numbers_;
  std::vector<std::size_t> lines_;
};

// How a record is written as a table for others.

struct Record;
struct RunInfo;

/// The record as text: comment lines with `#` that say what it is ("SIMULATED" first, if it is), a header of names with
/// units, one row per sample; an empty field where there is no value. Comments also say what makes a bias of the
/// numbers and a temperature of the readings: "axis u1.x: scale 0.1, earth rate 10.04" (arcsec per pulse, or °/h per
/// unit of a rate; and °/h, where the record knows it), "thermometer A: offset 0.01" (K), "thermometer A: polynomial 0
/// 1.001". Where the profile puts the unit into people's hands, a column says how it was mounted (turned_at): turned
/// around, the Earth's rate has the other sign. Quoted as in RFC 4180, lines end with LF; numbers are the shortest that
/// read back to the same value.
[[nodiscard]] std::string to_csv(const Record& record);
inline constexpr std::string_view kTurnedTitle = "turned";  ///< of that column
/// The same text, piece by piece: that of a record with many channels is larger than the record.
void write_csv(const Record& record, const std::function<void(std::string_view)>& sink);
/// … in two steps, of a record that grows: comments and header, then the rows behind second `after`.
void write_csv_head(const RunInfo& info, bool finished, const std::function<void(std::string_view)>& sink);
void write_csv_rows(const Record& record, std::int64_t after, const std::function<void(std::string_view)>& sink);

}  // namespace gyrotherm::record
