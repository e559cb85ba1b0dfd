// SPDX-License-Identifier: Apache-2.0
/// Text from people, instruments and files: UTF-8 validation, safe display in terminals, logs and tables, and
/// suggestions for misspelt keywords.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace gyrotherm {

/// Returns the size in bytes of the first character of `text`, or 0 if it is not valid UTF-8 (RFC 3629: no overlong
/// form, no surrogate, nothing above U+10FFFF). `text` must not be empty.
[[nodiscard]] std::size_t character_size(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

/// Returns the text without the characters `blanks` at its start and end.
[[nodiscard]] std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// Returns the text with each `from`, which must not be empty, replaced by `to`. Occurrences are searched from left to
/// right. They do not overlap, and the replacements are not searched.
[[nodiscard]] std::string substitute(std::string_view text, std::string_view from, std::string_view to);

/// Selects whether plain() escapes or keeps line ends and tabs.
enum class Blanks { escaped, kept };

/// Returns the text in UTF-8 without characters that could control a terminal or imitate the start of a line. Control
/// characters and bytes that are not UTF-8 are escaped as "\x1b"; control characters outside ASCII and marks of writing
/// direction (UAX #9) are escaped as "\u202e". Other text is unchanged.
[[nodiscard]] std::string plain(std::string_view text, Blanks blanks = Blanks::escaped);

/// Detects a file of another format by its first bytes. Returns "an SQLite file, as records are", "JSON", or "" for any
/// other content.
[[nodiscard]] std::string_view detect_other_format(std::string_view bytes);

/// Returns the element of `known` with the least edit distance to `word`, regardless of the case of ASCII letters.
/// Returns
/// "" if the least distance exceeds both 2 and a third of the length of `word`, or is half of the longer word or more.
[[nodiscard]] std::string find_nearest(std::string_view word, std::span<const std::string> known);

}  // namespace gyrotherm
