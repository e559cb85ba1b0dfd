/// The characters of a TOML file, looked at before its grammar is: what toml++ 3.3.0 could not bear does not come to
/// it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace gyrotherm {

/// What a text may hold at most; the text itself may have kLargestText bytes (text_file.hpp). toml++ makes a table of
/// each part of a dotted key and unmakes tables by recursion, and needs about 100 bytes of memory for each value.
struct TomlBounds {
  static constexpr std::size_t kDepth = 32;        ///< of keys' parts, tables and arrays in each other
  static constexpr std::size_t kKeys = 200'000;    ///< table headers included
  static constexpr std::size_t kValues = 500'000;  ///< in arrays
  static constexpr std::size_t kText = 65'536;     ///< bytes of one quoted text
  static constexpr std::size_t kWord = 1'024;      ///< bytes of one bare key or number
};

/// A character that cannot stand where it stands, or the first that is too much.
struct TextFlaw {
  unsigned line = 1, column = 1;  ///< of its first byte; columns count characters
  std::string what;
};

/// The first byte that is not UTF-8, or character beyond ASCII outside quoted texts and comments (TOML 1.0.0, "Keys"),
/// where toml++ 3.3.0 does not expect it: its behaviour is undefined there. For the same reason a line that continues a
/// text after a backslash must not begin with such a character. Also the first that passes one of the bounds. Nothing
/// of what follows a text that is never ended on its line: that is the grammar's to tell, and where the grammar fails,
/// nothing behind it is read.
[[nodiscard]] std::optional<TextFlaw> flaw_of(std::string_view text);

}  // namespace gyrotherm
