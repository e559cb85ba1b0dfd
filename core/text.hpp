// SPDX-License-Identifier: Apache-2.0
/// Text from people, instruments and files: its characters, how a terminal, a log or a table may show it, and which
/// known word a misspelt one is likely to mean.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace gyrotherm {

/// The bytes of the character that `text` begins with; 0 if it is not UTF-8 (RFC 3629: no overlong form, no surrogate,
/// nothing beyond U+10FFFF). The text must not be empty.
[[nodiscard]] std::size_t character_size(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

/// The text without the characters of `blanks` at its ends.
[[nodiscard]] std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// Whether plain() shows line ends and tabulators as text or keeps them.
enum class Blanks { escaped, kept };

/// The text in UTF-8, with whatever could steer a terminal, or let a line seem another one, shown as text: control
/// characters and bytes that are not UTF-8 like "\x1b", controls beyond ASCII and marks of writing direction (UAX #9)
/// like "\u202e". Text that has none of these stays as it is.
[[nodiscard]] std::string plain(std::string_view text, Blanks blanks = Blanks::escaped);

/// What bytes are by their beginning, where they are of a kind that people may have meant instead: "an SQLite file, as
/// records are", "JSON"; else "".
[[nodiscard]] std::string_view other_kind_of_file(std::string_view bytes);

/// The word of `known` with the least edit distance to `word`, or "" if none is near (distance over a third of its
/// length, at least 2).
[[nodiscard]] std::string nearest(std::string_view word, std::span<const std::string> known);

}  // namespace gyrotherm
