// SPDX-License-Identifier: Apache-2.0
/// The lines of a text that somebody else wrote, in UTF-8 whatever they were in.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "acquisition/exchange/bytes.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

enum class Encoding { utf8, utf16_little, utf16_big };

/// Text of one byte a character (Latin-1) as UTF-8; what is UTF-8 stays as it is.
[[nodiscard]] std::string in_utf8(std::string_view text);

class TextLines {
 public:
  /// Looks for a byte order mark: without one the text is taken for UTF-8. Lines that begin with `comment` do not
  /// count; with an empty one there are none. Fails as Bytes::ahead() does, and with bad_file where a text has NUL
  /// bytes at its beginning and no mark.
  [[nodiscard]] static Result<TextLines> open(Bytes bytes, std::string comment);

  /// Goes to the next line that is neither empty nor a comment, nor the first one if it is "sep=;" (which spreadsheets
  /// write before the header): these are passed over whatever their length. False at the end. A line ends with LF or
  /// CRLF. Fails with bad_file, with its place, if it has more than record::kLongestLine bytes, or a CR within.
  [[nodiscard]] Result<bool> next();
  /// Goes over the next line that is no comment, whatever stands in it; false at the end.
  [[nodiscard]] Result<bool> pass();
  /// Goes over the next line, a comment too; false at the end.
  [[nodiscard]] Result<bool> pass_any();
  /// Goes to the end of the line at which next() has failed, so that it can be called again.
  [[nodiscard]] Result<void> recover() { return pass_rest(); }

  /// Without its end; good until next().
  [[nodiscard]] std::string_view line() const { return line_; }
  /// Its number, from 1; of the last line passed over, where there is none. 0 before the first.
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] const std::string& file() const { return bytes_.name(); }
  /// Whether the line has an end; the last of a file that was being written may have none.
  [[nodiscard]] bool has_end() const { return has_end_; }

  /// A mistake of the line at a column, from 1: "file:line:column".
  [[nodiscard]] Fault mistake(std::size_t column, std::string what) const;

 private:
  TextLines(Bytes bytes, std::string comment, Encoding encoding)
      : bytes_(std::move(bytes)), comment_(std::move(comment)), encoding_(encoding) {}
  [[nodiscard]] Result<bool> read_line();
  [[nodiscard]] Result<void> check_ends() const;
  [[nodiscard]] Result<void> pass_rest();
  [[nodiscard]] bool counts() const;
  [[nodiscard]] bool is_comment() const;

  Bytes bytes_;
  std::string comment_;
  Encoding encoding_{};
  std::string_view line_{};
  std::string decoded_{};
  std::size_t to_pass_{};   ///< bytes of the line that line_ shows, with its end
  bool cut_short_ = false;  ///< line_ shows the beginning of a longer one
  bool has_end_ = true;
  std::size_t number_{};
};

}  // namespace gyrotherm::exchange
