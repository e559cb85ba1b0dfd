// SPDX-License-Identifier: Apache-2.0
/// Bytes in hexadecimal notation.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::tests {

/// Parses "19 00E0"; blanks are ignored.
[[nodiscard]] inline std::vector<std::byte> parse_hex_bytes(std::string_view text) {
  std::string digits;
  for (const char c : text)
    if (c != ' ') digits += c;
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoul(digits.substr(i, 2), nullptr, 16)));
  return bytes;
}

[[nodiscard]] inline std::string format_hex(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{}{:02X}", text.empty() ? "" : " ", std::to_integer<int>(byte));
  return text;
}

}  // namespace gyrotherm::tests
