#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "drivers/chamber/register_map_parts.hpp"

namespace gyrotherm {

namespace {

constexpr Vocabulary<CellSource, 15> kSources{{{"name", CellSource::name},
                                               {"number", CellSource::number},
                                               {"step_count", CellSource::step_count},
                                               {"step", CellSource::step},
                                               {"kind", CellSource::kind},
                                               {"start", CellSource::start},
                                               {"target", CellSource::target},
                                               {"rate", CellSource::rate},
                                               {"hours", CellSource::hours},
                                               {"minutes", CellSource::minutes},
                                               {"seconds", CellSource::seconds},
                                               {"total_seconds", CellSource::total_seconds},
                                               {"guaranteed_soak", CellSource::guaranteed_soak},
                                               {"soak_band", CellSource::soak_band},
                                               {"constant", CellSource::constant}}};
constexpr Vocabulary<StepKind, 3> kKinds{{{"ramp", StepKind::ramp}, {"soak", StepKind::soak}, {"end", StepKind::end}}};

void check_codes(const TomlTable& table, const MemoryCell& cell) {
  const auto must_have = [&](std::initializer_list<const char*> names) {
    for (const auto* name : names)
      if (!cell.form.codes.contains(name)) table.mistake("codes", fmt::format("no code is named \"{}\"", name));
  };
  if (cell.source == CellSource::kind) must_have({"ramp", "soak"});
  if (cell.source == CellSource::guaranteed_soak) must_have({"off", "on"});
}

MemoryCell read_cell(const TomlTable& table, const ItemDefaults& defaults) {
  MemoryCell cell;
  cell.at = bounded<std::uint16_t>(table, "at", table.integer("at", 0), 0, 122);
  cell.source = one_of(kSources, table, "holds", "constant");
  if (cell.source == CellSource::constant) cell.constant = table.number("value");
  read_form(table, defaults.order, cell.form);
  const bool is_text = cell.form.type == RegisterType::text;
  if (is_text != (cell.source == CellSource::name) || cell.form.type == RegisterType::date_time)
    table.mistake("type", "a program's name, and nothing else, is of type text; no cell is a date");
  check_codes(table, cell);
  return cell;
}

MemoryBlock read_block(const TomlTable& table, const ItemDefaults& defaults, const RegisterMap& map) {
  MemoryBlock block;
  block.address = read_address(table, "address", defaults.address_base);
  if (table.has("write_function")) block.function = one_of(kWriteFunctions, table, "write_function");
  for (const auto& word : table.texts("for"))
    for (const auto& [known, kind] : kKinds)
      if (word == known) block.kinds.push_back(kind);
  if (block.kinds.size() != table.texts("for").size()) table.mistake("for", "expected ramp, soak or end");
  block.select = table.boolean("select", false);
  block.read_back = !block.select && table.boolean("read_back", true);
  int end = 0;
  for (const auto& one : table.tables("cell")) {
    block.cells.push_back(read_cell(one, defaults));
    end = std::max(end, block.cells.back().at + word_count(block.cells.back().form));
  }
  if (block.cells.empty()) table.mistake("cell", "a block has at least one cell");
  block.count = bounded<std::uint16_t>(table, "count", table.integer("count", std::max(end, 1)), std::max(end, 1), 123);
  for (const auto& link : map.links)
    if (block.count > link.modbus.write_at_most)
      table.mistake("count", fmt::format("{} registers, of which at most {} can be written at once", block.count,
                                         link.modbus.write_at_most));
  if (block.address + block.count > 0x10000) table.mistake("address", "the block does not fit below address 65536");
  return block;
}

void check_steps(const TomlTable& table, const ProfileMemory& memory) {
  const auto has = [&](CellSource source) {
    return std::ranges::any_of(memory.step, [&](const auto& block) {
      return std::ranges::any_of(block.cells, [&](const auto& cell) { return cell.source == source; });
    });
  };
  if (!has(CellSource::target) && !has(CellSource::start))
    table.mistake("step", "no cell of a step holds its target or its start");
  const bool timed = has(CellSource::total_seconds) || (has(CellSource::hours) && has(CellSource::minutes));
  if (!timed) table.mistake("step", "the cells of a step do not hold its time");
  if (memory.ramps_by_rate && !has(CellSource::rate)) table.mistake("step", "no cell of a step holds the rate");
  for (const auto& block : memory.step)
    if (block.address + (memory.steps_at_most - 1) * memory.stride + block.count > 0x10000)
      table.mistake("steps_at_most", "the last step does not fit below address 65536");
}

}  // namespace

void read_memory(const TomlTable& table, const ItemDefaults& defaults, RegisterMap& map) {
  ProfileMemory memory;
  memory.steps_at_most = bounded<int>(table, "steps_at_most", table.integer("steps_at_most"), 1, 1000);
  memory.programs = bounded<int>(table, "programs", table.integer("programs", 1), 1, 1000);
  memory.first_program = bounded<int>(table, "first_program", table.integer("first_program", 1), 0, 1);
  memory.first_step = bounded<int>(table, "first_step", table.integer("first_step", 1), 0, 1);
  memory.stride = bounded<std::uint16_t>(table, "stride", table.integer("stride", 0), 0, 1000);
  memory.ramps_by_rate = table.choice("ramps_by", {"time", "rate"}, "time") == "rate";
  memory.end_step = table.boolean("end_step", false);
  memory.end_time = table.duration("end_time", {});
  memory.longest_step = table.duration("longest_step");
  memory.finest = table.duration("finest", std::chrono::seconds(1));
  if (memory.finest <= Duration{} || memory.longest_step < memory.finest)
    table.mistake("longest_step", "expected a longest step that is not shorter than \"finest\", and both positive");
  memory.pause = table.duration("pause", {});
  memory.recovery = table.duration("recovery", {});
  memory.number_from = table.text("number_from", "");
  if (!memory.number_from.empty()) (void)named_item(map, table, "number_from", memory.number_from);
  memory.confidence = one_of(kConfidences, table, "confidence", "unverified");
  for (const auto& block : table.tables("header")) memory.header.push_back(read_block(block, defaults, map));
  for (const auto& block : table.tables("step")) memory.step.push_back(read_block(block, defaults, map));
  for (const auto& block : table.tables("footer")) memory.footer.push_back(read_block(block, defaults, map));
  check_steps(table, memory);
  map.memory = std::move(memory);
}

}  // namespace gyrotherm
