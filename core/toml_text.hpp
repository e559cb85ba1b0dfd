/// The characters of a TOML file, looked at before its grammar is.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace gyrotherm {

/// A character that cannot stand where it stands.
struct TextFlaw {
  unsigned line = 1, column = 1;  ///< of its first byte; columns count characters
  std::string what;
};

/// The first byte that is not UTF-8, or character beyond ASCII outside quoted texts and comments (TOML 1.0.0, "Keys"),
/// where toml++ 3.3.0 does not expect it: its behaviour is undefined there. For the same reason a line that continues a
/// text after a backslash must not begin with such a character. Nothing of what follows a text that is never ended on
/// its line: that is the grammar's to tell.
[[nodiscard]] std::optional<TextFlaw> flaw_of(std::string_view text);

}  // namespace gyrotherm
