// SPDX-License-Identifier: Apache-2.0
/// Formats that people have and that are not read here, known by their first bytes.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace gyrotherm::exchange {

/// So many bytes of a file's beginning show what it is.
inline constexpr std::size_t kBeginningOfFormats = 1024;

/// What a file is that begins so and is not read here, and how it becomes one that is: "a zip archive: unpack it
/// first"; empty: nothing of the kind.
[[nodiscard]] std::string way_out_of_format(std::string_view beginning);

}  // namespace gyrotherm::exchange
