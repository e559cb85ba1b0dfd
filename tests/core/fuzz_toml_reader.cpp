// SPDX-License-Identifier: Apache-2.0
/// Fuzzes the TOML reader. Any text must be either read or refused with a position.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string>
#include <string_view>

#include "core/toml_reader.hpp"
#include "tests/support/fuzz_target.hpp"

namespace {

using gyrotherm::fuzz::require;

/// Calls every getter for every key, to a depth of eight tables.
void read_every_key(const gyrotherm::TomlTable& table, int depth) {
  for (const auto& key : table.keys()) {
    require(table.has(key));
    (void)table.number(key);
    (void)table.integer(key);
    (void)table.boolean(key, false);
    (void)table.choice(key, {"one", "other"});
    (void)table.duration(key);
    (void)table.celsius(key);
    (void)table.kelvins(key, {});
    (void)table.rate(key);
    (void)table.number_rows(key);
    (void)table.texts(key);
    (void)table.durations(key);
    require(table.location(key).starts_with("fuzz.toml:"));
    if (depth > 8) continue;
    read_every_key(table.table(key), depth + 1);
    for (const auto& child : table.tables(key)) read_every_key(child, depth + 1);
  }
}

void run(const std::string& text) {
  const auto root = gyrotherm::TomlTable::parse(text, "fuzz.toml");
  if (!root) return require(root.error().where.starts_with("fuzz.toml:"));
  read_every_key(*root, 0);
  if (const auto verdict = root->verdict(); !verdict) require(verdict.error().where.starts_with("fuzz.toml:"));
}

/// Composes a text that may take excessive work to parse. Each pair of bytes selects a piece of text and its number of
/// repetitions. The first pair becomes part of a key and repeats its piece up to 32,768 times.
std::string repeated_pieces(const std::uint8_t* data, std::size_t size) {
  constexpr std::string_view kPieces[] = {
      "a",       ".a", "[", "]",   "{", "}", "=",   " = 1\n", "\n",  ",",    "\"",       "'",   "'''",    "\"\"\"",
      "[[a]]\n", "\\", "#", "1.5", "°", "k", "{b=", "{},",    "[],", "x = ", "\"\\\"\"", ". a", "[a.b]\n"};
  const auto repeated = [&](std::size_t i, int most) {
    std::string text;
    for (int times = 1 << data[i + 1] % most; times > 0; --times) text += kPieces[data[i] % std::size(kPieces)];
    return text;
  };
  std::string text = size < 2 ? "" : "k" + repeated(0, 16) + " = 1\n";
  for (std::size_t i = 2; i + 1 < size; i += 2) text += repeated(i, 7);
  return text;
}

}  // namespace

FUZZ_TARGET(toml_reader, const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (const auto d = gyrotherm::parse_duration(bytes)) require(*d >= gyrotherm::Duration::zero());
  run(bytes);
  if (size == 2 || size % 32 == 12) run(repeated_pieces(data, std::min<std::size_t>(size, 12)));
  run("a = \"" + bytes + "\"\nb = [1, 2]\n[c]\nd = 5\n[[e]]\nf = [[1, 2]]\n");
  return 0;
}
