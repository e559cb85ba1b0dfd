// SPDX-License-Identifier: Apache-2.0
/// The texts of shipped TOML files as inputs of fuzz targets.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace gyrotherm::tests {

/// Reads all TOML files of a folder, in the order of their texts.
inline std::vector<std::string> read_shipped_texts(const std::filesystem::path& folder) {
  std::vector<std::string> texts;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".toml") continue;
    std::ifstream file(entry.path(), std::ios::binary);
    texts.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  std::ranges::sort(texts);
  return texts;
}

/// Returns the text with up to four characters replaced, one by each three bytes that follow data[0].
inline std::string edit_text(std::string text, const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostEdits = 4;
  for (std::size_t i = 1; i + 2 < std::min(size, 1 + 3 * kMostEdits); i += 3)
    text[(data[i] << 8 | data[i + 1]) % text.size()] = static_cast<char>(data[i + 2]);
  return text;
}

}  // namespace gyrotherm::tests
