/// Text from instruments and files as a terminal, a log or a table may show it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace gyrotherm {

/// Bytes of the character that `text` begins with; 0 if it is not UTF-8 (RFC 3629: no overlong form, no surrogate,
/// nothing beyond U+10FFFF). The text must not be empty.
[[nodiscard]] std::size_t character_size(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

enum class Blanks { escaped, kept };  ///< of line ends and tabulators

/// The text in UTF-8, with whatever could steer a terminal, or let a line seem another one, shown as text: control
/// characters and bytes that are not UTF-8 like "\x1b", controls beyond ASCII and marks of writing direction (UAX #9)
/// like "\u202e". Text that has none of these stays as it is.
[[nodiscard]] std::string plain(std::string_view text, Blanks blanks = Blanks::escaped);

}  // namespace gyrotherm
