/// Any text is either read or refused with a place, whatever is asked of it.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/toml_reader.hpp"

namespace {

void require(bool law) {
  if (!law) std::abort();
}

/// Asks every question of every key.
void interrogate(const gyrotherm::TomlTable& table, int depth) {
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
    require(table.place(key).starts_with("fuzz.toml:"));
    if (depth > 8) continue;
    interrogate(table.table(key), depth + 1);
    for (const auto& child : table.tables(key)) interrogate(child, depth + 1);
  }
}

void run(const std::string& text) {
  const auto root = gyrotherm::TomlTable::parse(text, "fuzz.toml");
  if (!root) return require(root.error().where.starts_with("fuzz.toml:"));
  interrogate(*root, 0);
  if (const auto verdict = root->verdict(); !verdict) require(verdict.error().where.starts_with("fuzz.toml:"));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  if (const auto d = gyrotherm::parse_duration(bytes)) require(*d >= gyrotherm::Duration::zero());
  run(bytes);
  run("a = \"" + bytes + "\"\nb = [1, 2]\n[c]\nd = 5\n[[e]]\nf = [[1, 2]]\n");
  return 0;
}
