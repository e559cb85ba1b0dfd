// SPDX-License-Identifier: Apache-2.0
#include "drivers/analogue/analogue_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/toml_reader.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::size_t kMostInputs = 256;

/// The item of that name, or those that `count` made of it; none, and a mistake, if there is neither.
std::vector<const RegisterItem*> items_named(const RegisterMap& map, const TomlTable& table, const char* key,
                                             const std::string& name) {
  if (const auto* one = map.find(name)) return {one};
  std::vector<const RegisterItem*> all;
  while (const auto* next = map.find(fmt::format("{}_{}", name, all.size() + 1))) all.push_back(next);
  if (all.empty()) (void)named_item(map, table, key, name);
  return all;
}

void check_number(const TomlTable& table, const char* key, const RegisterItem& item) {
  if (!item.readable) table.mistake(key, fmt::format("register \"{}\" cannot be read", item.name));
  if (item.type == RegisterType::text || item.type == RegisterType::date_time)
    table.mistake(key, fmt::format("register \"{}\" is no number", item.name));
}

/// One name, or a list of them, or none.
std::vector<std::string> names_at(const TomlTable& table, const char* key) {
  if (!table.has(key)) return {};
  if (table.is_list(key)) return table.texts(key);
  return {table.text(key)};
}

/// The status registers of that name belong to the inputs from `first` on, one each.
void add_status(const TomlTable& table, const std::string& status, std::size_t first, AnalogueMap& map) {
  const auto states = items_named(map.registers, table, "status", status);
  const auto inputs = map.inputs.size() - first;
  if (!states.empty() && states.size() != inputs)
    table.mistake("status", fmt::format("{} status registers for {} inputs", states.size(), inputs));
  for (std::size_t i = 0; i < std::min(states.size(), inputs); ++i) {
    const auto& state = *states[i];
    check_number(table, "status", state);
    if (!state.codes.contains(kNormalStatus))
      table.mistake("status", fmt::format("register \"{}\" has no code named \"{}\"", state.name, kNormalStatus));
    map.inputs[first + i].statuses.push_back(state.name);
  }
}

void add_inputs(const TomlTable& table, AnalogueMap& map) {
  const auto values = items_named(map.registers, table, "register", table.text("register"));
  const auto unit = table.text("unit");
  if (unit.empty()) table.mistake("unit", "expected the unit of measure, such as \"mA\"");
  const auto first = map.inputs.size();
  for (const auto* value : values) {
    check_number(table, "register", *value);
    map.inputs.push_back({.item = value->name, .unit = unit, .statuses = {}});
  }
  for (const auto& status : names_at(table, "status")) add_status(table, status, first, map);
}

}  // namespace

Result<AnalogueMap> parse_analogue_map(std::string_view text, const std::string& file,
                                       std::optional<WordOrder> word_order) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());
  AnalogueMap map;
  map.registers.text = text;
  (void)parsed->choice("schema", {"gyrotherm-analogue-inputs/1"});
  read_unit(*parsed, word_order, map.registers);
  for (const auto& table : parsed->tables("input")) add_inputs(table, map);
  if (map.inputs.empty()) parsed->mistake("", "missing [[input]], expected at least one");
  if (map.inputs.size() > kMostInputs)
    parsed->mistake("input", fmt::format("{} inputs, expected at most {}", map.inputs.size(), kMostInputs));
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  const auto usual = map.registers.links.front().kind;
  auto linked = on_link(std::move(map.registers), usual);
  if (!linked) return failure(std::move(linked.error()));
  map.registers = std::move(*linked);
  return map;
}

std::string confidence_in_words(const AnalogueMap& map) {
  auto least_sure = Confidence::verified;
  std::vector<std::string> notes;
  const auto look_at = [&](const std::string& name) {
    const auto* item = map.registers.find(name);
    if (!item) return;
    least_sure = std::max(least_sure, item->confidence);
    if (!item->note.empty() && std::ranges::count(notes, item->note) == 0) notes.push_back(item->note);
  };
  for (const auto& input : map.inputs) {
    look_at(input.item);
    for (const auto& status : input.statuses) look_at(status);
  }
  return fmt::format("{} inputs: {}{}{}", map.inputs.size(), name(least_sure), notes.empty() ? "" : "; ",
                     fmt::join(notes, "; "));
}

}  // namespace gyrotherm::drivers
