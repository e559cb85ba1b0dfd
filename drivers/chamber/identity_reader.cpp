// SPDX-License-Identifier: Apache-2.0
// Reads the table [identity] of a register map: the fingerprint and the settings to compare.
#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::drivers {
namespace {

/// Returns whether every class is closed and not empty: "[1-4" and "[]" are invalid.
bool is_pattern(std::string_view pattern) {
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '[') continue;
    const auto end = pattern.find(']', i + 1);
    if (end == std::string_view::npos || end == i + 1 || pattern.substr(i, end - i) == "[!") return false;
    i = end;
  }
  return true;
}

std::string read_pattern(const TomlTable& table) {
  auto pattern = table.text("pattern");
  if (!is_pattern(pattern))
    table.note_error("pattern", fmt::format("\"{}\" has a character class that is empty or not closed", pattern));
  return pattern;
}

const RegisterItem* find_readable_item(const TomlTable& table, const RegisterMap& map, const std::string& name) {
  const auto* item = find_named_item(map, table, item_key(table), name);
  if (item && !item->readable) table.note_error(item_key(table), fmt::format("register \"{}\" cannot be read", name));
  return item;
}

Fingerprint read_fingerprint(const TomlTable& table, const RegisterMap& map, const std::string& name) {
  Fingerprint print;
  print.item = name;
  const auto* item = find_readable_item(table, map, name);
  if (item && item->type == RegisterType::text) {
    print.pattern = read_pattern(table);
    return print;
  }
  print.value = table.number("value");
  print.mask = whole<std::uint32_t>(table, "mask", 1, 0xFFFFFFFF, 0xFFFFFFFF);
  return print;
}

VerifiedSetting read_setting(const TomlTable& table, const RegisterMap& map) {
  VerifiedSetting setting{
      .item = table.text(item_key(table)), .verifies = table.text("verifies", ""), .when = {}, .pattern = {}};
  const auto* item = find_readable_item(table, map, setting.item);
  const bool is_text = item && item->type == RegisterType::text;
  if (setting.verifies.empty()) return setting;
  if (is_text)
    setting.pattern = read_pattern(table);
  else
    setting.when = read_condition(table, map);
  return setting;
}

}  // namespace

void read_identity(const TomlTable& table, RegisterMap& map) {
  if (table.has("register")) map.identity = read_fingerprint(table, map, table.text("register"));
  read_verification(table, map);
}

void read_verification(const TomlTable& table, RegisterMap& map) {
  auto& verification = map.verification;
  verification.verifies = table.text("verifies", "");
  for (const auto& name : table.texts("shows")) {
    if (find_readable_item(table, map, name)) verification.shows.push_back(name);
  }
  for (const auto& one : table.tables("setting")) verification.settings.push_back(read_setting(one, map));
  for (const auto& one : table.tables("other_map"))
    verification.other_maps.push_back(
        {read_fingerprint(one, map, map.identity ? map.identity->item : ""), one.text("map"), one.text("what")});
  verification.not_verified = table.texts("not_verified");
}

}  // namespace gyrotherm::drivers
