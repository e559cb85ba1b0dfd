// SPDX-License-Identifier: Apache-2.0
/// Numbers of things in messages.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <string>
#include <string_view>

namespace gyrotherm {

/// Returns "1 row", "2 rows": the number with the noun, whose plural ends in s.
[[nodiscard]] std::string format_count(std::integral auto number, std::string_view noun) {
  return fmt::format("{} {}{}", number, noun, number == 1 ? "" : "s");
}

}  // namespace gyrotherm
