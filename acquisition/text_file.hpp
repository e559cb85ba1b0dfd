/// Whole text files.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

/// Fails with bad_file if there is no such file or it cannot be read.
[[nodiscard]] Result<std::string> read_text_file(const std::string& path);

/// Replaces the file as a whole, by a temporary name and a rename: a reader sees the old one or the new one.
/// Fails with storage; then the old one stands.
[[nodiscard]] Result<void> replace_text_file(const std::string& path, std::string_view text);

}  // namespace gyrotherm
