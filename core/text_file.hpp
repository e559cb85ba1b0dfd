/// A whole text file, read or replaced.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

/// Fails with bad_file if it cannot be read or is larger than 256 MB.
[[nodiscard]] Result<std::string> read_text_file(const std::string& path);

/// Replaces the file as a whole: written under a temporary name, synced, renamed; a link's target is replaced, the link
/// stays. Fails with storage, also where the path is a device, a pipe or a folder.
[[nodiscard]] Result<void> replace_text_file(const std::string& path, std::string_view text);

/// Likewise without waiting for the disk: for what need not outlive the machine.
[[nodiscard]] Result<void> replace_passing_text_file(const std::string& path, std::string_view text);

}  // namespace gyrotherm
