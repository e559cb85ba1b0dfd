/// What the files that describe instruments have in common: words that stand for values, bounded whole numbers, and
/// files that they name.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
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

/// The whole number at `key`, of 32 bits.
[[nodiscard]] inline std::uint32_t word32(const TomlTable& table, const char* key, std::int64_t fallback) {
  return bounded<std::uint32_t>(table, key, table.integer(key, fallback), 0, 0xFFFFFFFF);
}

/// Whether the most significant byte comes first.
inline constexpr Vocabulary<bool, 2> kEndians{{{"little", false}, {"big", true}}};

struct NamedText {
  std::string path;
  std::string text;
};
/// The file that `key` names, relative to the folder of `file`, or `known` in place of its text, as a record keeps it.
/// Fails with bad_file, at the place of the key.
[[nodiscard]] Result<NamedText> read_named(const TomlTable& table, const char* key, const std::string& file,
                                           const std::optional<std::string>& known);

}  // namespace gyrotherm
