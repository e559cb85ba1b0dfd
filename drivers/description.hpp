/// What the files that describe instruments have in common: words that stand for values, and bounded whole numbers.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/toml_reader.hpp"

namespace gyrotherm {

template <class T, std::size_t N>
using Vocabulary = std::array<std::pair<const char*, T>, N>;

/// The value that the word at `key` stands for; any other word is a mistake. Without a `fallback` the key is required.
template <class T, std::size_t N>
[[nodiscard]] T one_of(const Vocabulary<T, N>& words, const TomlTable& table, const char* key,
                       const char* fallback = "") {
  std::vector<std::string> allowed;
  for (const auto& [word, value] : words) allowed.emplace_back(word);
  const auto chosen = table.choice(key, allowed, fallback);
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& entry) { return chosen == entry.first; });
  return found == words.end() ? words.front().second : found->second;
}

/// `value`, read at `key`, as a T; outside [low, high] is a mistake, and the nearest bound is returned.
template <class T>
[[nodiscard]] T bounded(const TomlTable& table, const char* key, std::int64_t value, std::int64_t low,
                        std::int64_t high) {
  if (value < low || value > high)
    table.mistake(key, fmt::format("\"{}\" is {}, expected {} to {}", key, value, low, high));
  return static_cast<T>(std::clamp(value, low, high));
}

}  // namespace gyrotherm
