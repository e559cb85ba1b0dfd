// SPDX-License-Identifier: Apache-2.0
/// Character-level checks and quoting for TOML. The characters of a file are checked before its grammar is parsed,
/// because toml++ 3.3.0 cannot handle every input safely.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace gyrotherm {

/// Limits of a TOML text; the whole text may have kLargestText bytes (core/file.hpp). The limits exist because toml++
/// makes a table for each part of a dotted key, destroys tables recursively, and needs about 100 bytes of memory per
/// value.
struct TomlBounds {
  /// Nesting depth: key parts, tables and arrays together.
  static constexpr std::size_t kDepth = 32;
  static constexpr std::size_t kKeys = 200'000;    ///< table headers included
  static constexpr std::size_t kValues = 500'000;  ///< array elements
  static constexpr std::size_t kText = 65'536;     ///< bytes, quoted text
  static constexpr std::size_t kWord = 1'024;      ///< bytes, bare key or number
};

/// The first character that is not allowed at its position or exceeds a limit. The position refers to the character's
/// first byte; columns are counted in characters.
struct TextFlaw {
  unsigned line = 1, column = 1;
  std::string what;
};

/// Finds the first flaw of a text, if there is one. Flaws are:
/// - a byte that is not UTF-8;
/// - a character outside ASCII that is not in a quoted text or a comment (TOML 1.0.0, "Keys");
/// - a character outside ASCII at the start of a line that continues a text after a backslash, for which the behaviour
///   of toml++ 3.3.0 is undefined;
/// - a character that exceeds one of the limits.
/// The check ends at a line whose closing quote is missing, because the parser fails there.
[[nodiscard]] std::optional<TextFlaw> find_flaw(std::string_view text);

/// Returns the text as a TOML basic string on one line, with quotation marks. The text must be UTF-8.
[[nodiscard]] std::string toml_quoted(std::string_view text);

}  // namespace gyrotherm
