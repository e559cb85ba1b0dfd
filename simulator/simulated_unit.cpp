// SPDX-License-Identifier: Apache-2.0
#include "simulator/simulated_unit.hpp"

#include <fmt/format.h>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map_reader.hpp"

namespace gyrotherm::simulator {
namespace {

SimulatedUnit unit_of(const TomlTable& table, const drivers::RegisterMap& map) {
  SimulatedUnit unit;
  const auto conditions = [&](const char* key, std::vector<drivers::Condition>& all) {
    for (const auto& one : table.tables(key)) all.push_back(drivers::read_condition(one, map));
  };
  conditions("turns_on", unit.turns_on);
  conditions("turns_off", unit.turns_off);
  conditions("starts_program", unit.starts_program);
  conditions("holds_program", unit.holds_program);
  conditions("resumes_program", unit.resumes_program);
  conditions("ends_program", unit.ends_program);
  conditions("creates_program", unit.creates_program);
  conditions("stores_program", unit.stores_program);
  conditions("loads_program", unit.loads_program);
  unit.program_number = table.text("program_number", "");
  unit.program_step = table.text("program_step", "");
  for (const auto& one : table.tables("shows")) {
    SimulatedUnit::Shows shows{.item = one.text("register"), .values = {}};
    const auto* item = drivers::named_item(map, one, "register", shows.item);
    for (const auto* state : {"off", "on", "running", "ramping", "soaking", "held", "done"}) {
      if (!one.has(state)) continue;
      const auto code = item && !item->codes.empty() ? drivers::code_of(*item, one.text(state)) : one.number(state);
      if (!code) one.mistake(state, fmt::format("register \"{}\" has no such code", shows.item));
      shows.values[state] = code.value_or(0);
    }
    unit.shows.push_back(std::move(shows));
  }
  for (const auto& one : table.tables("initial")) {
    const auto name = one.text("register");
    (void)drivers::named_item(map, one, "register", name);
    if (one.has("text"))
      unit.initial_texts.emplace_back(name, one.text("text"));
    else
      unit.initial.emplace_back(name, one.number("value"));
  }
  unit.when_off = table.texts("sentinel_when_off");
  for (const auto& name : unit.when_off) (void)drivers::named_item(map, table, "sentinel_when_off", name);
  unit.silent_exceptions = table.boolean("silent_exceptions", false);
  unit.ignores_blocks_elsewhere = table.boolean("ignores_blocks_elsewhere", false);
  return unit;
}

}  // namespace

Result<SimulatedUnit> read_simulated_unit(const drivers::RegisterMap& map, const std::string& file) {
  const auto parsed = TomlTable::parse(map.text, file);
  if (!parsed) return failure(parsed.error());
  for (const auto& key : parsed->keys())
    if (key != "simulated") parsed->ignore(key);
  auto unit = unit_of(parsed->table("simulated"), map);
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return unit;
}

}  // namespace gyrotherm::simulator
