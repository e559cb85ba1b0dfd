/// Fingerprints of texts for provenance.
#pragma once

#include <string>
#include <string_view>

namespace gyrotherm {

/// 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace gyrotherm
