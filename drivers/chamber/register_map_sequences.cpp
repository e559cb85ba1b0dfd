#include <fmt/format.h>

#include <array>
#include <chrono>

#include "drivers/chamber/register_map_parts.hpp"

namespace gyrotherm {

namespace {

constexpr Duration kUsualPatience = std::chrono::seconds(5);
const std::vector<std::string> kCommands{"start",   "stop",          "pause",        "resume",       "acknowledge",
                                         "advance", "start_program", "stop_program", "begin_upload", "end_upload"};

/// What is written: a number, the code of a meaning, a parameter of the command, or another item's time.
void read_value(const TomlTable& table, const RegisterMap& map, const RegisterItem* item, SequenceStep& step) {
  if (table.has("code")) {
    const auto meaning = table.text("code");
    const auto code = item ? code_of(*item, meaning) : std::nullopt;
    if (item && !code)
      table.mistake("code", fmt::format("register \"{}\" has no code named \"{}\"", item->name, meaning));
    step.value = code.value_or(0);
  } else if (table.has("of")) {
    step.source = table.choice("of", {"program", "step"}) == "program" ? SequenceStep::Source::program
                                                                       : SequenceStep::Source::step;
    step.value = table.number("plus", 0);
  } else if (table.has("date_of")) {
    step.source = SequenceStep::Source::date;
    step.date_of = table.text("date_of");
    step.duration = table.duration("later", {});
    const auto* clock = named_item(map, table, "date_of", step.date_of);
    if ((clock && clock->type != RegisterType::date_time) || (item && item->type != RegisterType::date_time))
      table.mistake("date_of", "both registers must be of type date_time");
  } else {
    step.value = table.number("value");
  }
}

SequenceStep read_step(const TomlTable& table, const RegisterMap& map) {
  SequenceStep step;
  if (table.has("when")) step.only_if = read_condition(table.table("when"), map);
  if (table.has("write")) {
    step.kind = SequenceStep::Kind::write;
    step.item = table.text("write");
    const auto* item = named_item(map, table, "write", step.item);
    if (item && !item->writable) table.mistake("write", fmt::format("register \"{}\" is not writable", item->name));
    read_value(table, map, item, step);
  } else if (table.has("wait")) {
    step.kind = SequenceStep::Kind::wait;
    step.until = read_condition(table.table("wait"), map);
    step.item = step.until.item;
    step.duration = table.duration("within", kUsualPatience);
  } else {
    step.kind = SequenceStep::Kind::pause;
    step.duration = table.duration("pause");
  }
  return step;
}

}  // namespace

void read_sequences(const TomlTable& table, RegisterMap& map) {
  for (const auto& name : table.keys()) {
    if (std::find(kCommands.begin(), kCommands.end(), name) == kCommands.end())
      table.mistake(name, fmt::format("\"{}\" is none of {}", name, fmt::join(kCommands, ", ")));
    auto& steps = map.sequences[name];
    for (const auto& step : table.tables(name)) steps.push_back(read_step(step, map));
    if (steps.empty()) table.mistake(name, fmt::format("\"{}\" has no steps", name));
  }
}

void read_simulated(const TomlTable& table, RegisterMap& map) {
  auto& unit = map.simulated;
  const auto conditions = [&](const char* key, std::vector<Condition>& all) {
    for (const auto& one : table.tables(key)) all.push_back(read_condition(one, map));
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
    const auto* item = named_item(map, one, "register", shows.item);
    for (const auto* state : {"off", "on", "running", "ramping", "soaking", "held", "done"}) {
      if (!one.has(state)) continue;
      const auto code = item && !item->codes.empty() ? code_of(*item, one.text(state)) : one.number(state);
      if (!code) one.mistake(state, fmt::format("register \"{}\" has no such code", shows.item));
      shows.values[state] = code.value_or(0);
    }
    unit.shows.push_back(std::move(shows));
  }
  for (const auto& one : table.tables("initial")) {
    const auto name = one.text("register");
    (void)named_item(map, one, "register", name);
    if (one.has("text"))
      unit.initial_texts.emplace_back(name, one.text("text"));
    else
      unit.initial.emplace_back(name, one.number("value"));
  }
  unit.when_off = table.texts("sentinel_when_off");
  for (const auto& name : unit.when_off) (void)named_item(map, table, "sentinel_when_off", name);
  unit.silent_exceptions = table.boolean("silent_exceptions", false);
  unit.ignores_blocks_elsewhere = table.boolean("ignores_blocks_elsewhere", false);
}

}  // namespace gyrotherm
