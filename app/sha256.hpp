/// Fingerprints of files and texts for provenance.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

/// 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);
/// Fails with bad_file if the file cannot be read.
[[nodiscard]] Result<std::string> sha256_of_file(const std::string& path);

}  // namespace gyrotherm
