// SPDX-License-Identifier: Apache-2.0
/// Reads the lines of a text file of another program and converts them to UTF-8.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "acquisition/exchange/bytes.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

enum class Encoding { utf8, utf16_little, utf16_big };

/// Converts Latin-1 text to UTF-8. Returns text that is UTF-8 already unchanged.
[[nodiscard]] std::string in_utf8(std::string_view text);

/// Iterates over the lines of a text file.
class TextLines {
 public:
  /// Detects the encoding by a byte order mark. A text without one is UTF-8. Lines that begin with `comment` are
  /// ignored; an empty `comment` matches none. Fails as Bytes::ahead() does, and with bad_file if a text without a mark
  /// has NUL bytes at its beginning.
  [[nodiscard]] static Result<TextLines> open(Bytes bytes, std::string comment);

  /// Advances to the next line that is neither empty nor a comment. Also ignores a first line "sep=;", which
  /// spreadsheets write before the header. Ignored lines may have any length. Returns false at the end. A line ends
  /// with LF or CRLF. Fails with bad_file and the position if a line has more than record::kLongestLine bytes or
  /// contains a CR.
  [[nodiscard]] Result<bool> next();
  /// Skips the next line that is not a comment, even an empty one. Returns false at the end.
  [[nodiscard]] Result<bool> skip_line();
  /// Skips the next line, even a comment. Returns false at the end.
  [[nodiscard]] Result<bool> skip_any_line();
  /// Advances to the end of the line at which next() failed, so that next() can be called again.
  [[nodiscard]] Result<void> recover() { return skip_remainder(); }

  /// Returns the line without its end. The view is valid until next().
  [[nodiscard]] std::string_view line() const { return line_; }
  /// Returns the number of the line, from 1, or of the last skipped line; 0 before the first line.
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] const std::string& file() const { return bytes_.name(); }
  /// Returns whether the line has an end. The last line of a file that was still being written may have none.
  [[nodiscard]] bool has_end() const { return has_end_; }

  /// Returns a fault at a column of the line, from 1: "file:line:column".
  [[nodiscard]] Fault fault_at(std::size_t column, std::string what) const;

 private:
  TextLines(Bytes bytes, std::string comment, Encoding encoding)
      : bytes_(std::move(bytes)), comment_(std::move(comment)), encoding_(encoding) {}
  [[nodiscard]] Result<bool> read_line();
  [[nodiscard]] Result<void> check_ends() const;
  [[nodiscard]] Result<void> skip_remainder();
  [[nodiscard]] bool has_content() const;
  [[nodiscard]] bool is_comment() const;

  Bytes bytes_;
  std::string comment_;
  Encoding encoding_{};
  std::string_view line_{};
  std::string decoded_{};
  /// The size in bytes of the present line, including its end. The next read skips these bytes.
  std::size_t bytes_to_skip_{};
  /// `line_` is the beginning of a longer line.
  bool cut_short_ = false;
  bool has_end_ = true;
  std::size_t number_{};
};

}  // namespace gyrotherm::exchange
