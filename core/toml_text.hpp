// SPDX-License-Identifier: Apache-2.0
/// The characters of TOML: those of a file are looked at before its grammar is read, so that what toml++ 3.3.0 could
/// not bear does not come to it; those of a text that is written are escaped.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace gyrotherm {

/// What a text may hold at most; the text itself may have kLargestText bytes (core/file.hpp). toml++ makes a table
/// of each part of a dotted key and unmakes tables by recursion, and needs about 100 bytes of memory for each value.
struct TomlBounds {
  static constexpr std::size_t kDepth = 32;        ///< of keys' parts, tables and arrays in each other
  static constexpr std::size_t kKeys = 200'000;    ///< table headers included
  static constexpr std::size_t kValues = 500'000;  ///< in arrays
  static constexpr std::size_t kText = 65'536;     ///< bytes of one quoted text
  static constexpr std::size_t kWord = 1'024;      ///< bytes of one bare key or number
};

/// A character that cannot stand where it stands, or the first that is too much. The place is that of its first byte;
/// columns count characters.
struct TextFlaw {
  unsigned line = 1, column = 1;
  std::string what;
};

/// Finds the first flaw of a text; nothing if there is none. Flaws are
/// - a byte that is not UTF-8;
/// - a character beyond ASCII outside quoted texts and comments (TOML 1.0.0, "Keys"), or at the beginning of a line
/// that
///   continues a text after a backslash: toml++ 3.3.0 does not expect it there, and its behaviour is undefined;
/// - a character that passes one of the bounds.
/// What follows a text that is never ended on its line is not looked at: that text is the grammar's to tell, and where
/// the grammar fails, nothing behind it is read.
[[nodiscard]] std::optional<TextFlaw> flaw_of(std::string_view text);

/// The text as a basic string of TOML, on one line, in quotation marks. It must be UTF-8.
[[nodiscard]] std::string toml_quoted(std::string_view text);

}  // namespace gyrotherm
