// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/register_map_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <set>

namespace gyrotherm::drivers {
namespace {

constexpr double kFinestOfFloat = 0.001;
constexpr std::int64_t kMostOfOneKind = 256;

constexpr Vocabulary<RegisterType, 8> kTypes{{{"u16", RegisterType::u16},
                                              {"s16", RegisterType::s16},
                                              {"u32", RegisterType::u32},
                                              {"s32", RegisterType::s32},
                                              {"f32", RegisterType::f32},
                                              {"bits", RegisterType::bits},
                                              {"text", RegisterType::text},
                                              {"date_time", RegisterType::date_time}}};
constexpr Vocabulary<DatePart, 7> kDateParts{{{"year", DatePart::year},
                                              {"month", DatePart::month},
                                              {"day", DatePart::day},
                                              {"weekday", DatePart::weekday},
                                              {"hour", DatePart::hour},
                                              {"minute", DatePart::minute},
                                              {"second", DatePart::second}}};

void read_text_form(const TomlTable& table, TextForm& form) {
  form.characters = bounded<std::uint16_t>(table, "characters", table.integer("characters"), 1, 125);
  form.per_register = bounded<std::uint8_t>(table, "per_register", table.integer("per_register", 2), 1, 2);
  form.low_byte_first = table.boolean("low_byte_first", false);
  form.stride = bounded<std::uint16_t>(table, "stride", table.integer("stride", 1), 1, 16);
  form.padding = table.choice("padding", {"space", "zero"}, "space") == "zero" ? '\0' : ' ';
}

std::optional<DatePart> date_part(const TomlTable& table, const std::string& word) {
  for (const auto& [known, part] : kDateParts)
    if (word == known) return part;
  table.mistake("parts", fmt::format("\"{}\" is none of year, month, day, weekday, hour, minute, second", word));
  return std::nullopt;
}

/// ["year/month", "day/weekday", "hour/minute", "second"]: the high byte first.
void read_date_form(const TomlTable& table, DateForm& form) {
  for (const auto& word : table.texts("parts")) {
    const auto slash = word.find('/');
    const auto high = date_part(table, word.substr(0, slash));
    DateForm::Word parts{high.value_or(DatePart::year), std::nullopt};
    if (slash != std::string::npos) parts.low = date_part(table, word.substr(slash + 1));
    form.words.push_back(parts);
  }
  if (form.words.empty() || form.words.size() > 7) table.mistake("parts", "expected one to seven registers of parts");
  form.stride = bounded<std::uint16_t>(table, "stride", table.integer("stride", 1), 1, 16);
  form.century = bounded<int>(table, "century", table.integer("century", 0), 0, 2100);
}

void read_bits(const TomlTable& table, RegisterItem& item) {
  item.first_bit = bounded<std::uint8_t>(table, "bit", table.integer("bit"), 0, 15);
  item.bit_count = bounded<std::uint8_t>(table, "width", table.integer("width", 1), 1, 16 - item.first_bit);
}

void read_scale(const TomlTable& table, RegisterItem& item) {
  const auto positive = [&](const char* key, double value) {
    if (value <= 0) table.mistake(key, fmt::format("\"{}\" is {}, expected a positive number", key, value));
    return value > 0 ? value : 1;
  };
  item.scale = positive("scale", table.number("scale", 1));
  item.offset = table.number("offset", 0);
  if (table.has("write_scale")) item.write_scale = positive("write_scale", table.number("write_scale"));
  const double finest = std::max(item.scale, item.write_scale.value_or(0));
  item.resolution =
      positive("resolution", table.number("resolution", item.type == RegisterType::f32 ? kFinestOfFloat : finest));
}

void read_codes(const TomlTable& table, RegisterItem& item) {
  const auto codes = table.table("codes");
  for (const auto& name : codes.keys()) {
    auto& all = item.codes[name];
    if (codes.is_list(name))
      for (const double code : codes.numbers(name))
        all.push_back(static_cast<std::int64_t>(std::clamp(code, -1e9, 1e10)));
    else
      all.push_back(codes.integer(name));
    if (all.empty()) codes.mistake(name, fmt::format("\"{}\" has no code", name));
  }
  const auto flags = table.table("flags");
  for (const auto& name : flags.keys())
    item.flags[name] =
        bounded<std::uint8_t>(flags, name.c_str(), flags.integer(name), 0, word_count(item.type) * 16 - 1);
  const bool words = item.type == RegisterType::u16 || item.type == RegisterType::u32;
  if (!item.flags.empty() && !words) table.mistake("flags", "flags are bits of a u16 or u32");
  item.otherwise = table.text("otherwise", "");
}

void read_functions(const TomlTable& table, const ItemDefaults& defaults, RegisterItem& item) {
  item.read_function = defaults.read_function;
  item.write_function = defaults.write_function;
  if (table.has("read_function")) item.read_function = one_of(kReadFunctions, table, "read_function");
  if (table.has("write_function")) item.write_function = one_of(kWriteFunctions, table, "write_function");
}

void read_access(const TomlTable& table, RegisterItem& item) {
  const auto access = table.choice("access", {"r", "rw", "w", "command"}, "r");
  item.readable = access == "r" || access == "rw";
  item.writable = access != "r";
  item.self_clearing = access == "command";
  item.seen_in = table.text("seen_in", "");
  if (table.has("tolerance")) item.tolerance = table.number("tolerance");
  item.seen_within = table.duration("within", {});
  item.seen_later = table.boolean("seen_later", false);
  if (item.seen_later && item.name != "set_point")
    table.mistake("seen_later", "only the set point is read again by itself");
  item.also = table.texts("also");
  if (!table.has("together_with")) return;
  const auto other = table.table("together_with");
  item.companion = Companion{other.text("register"), other.number("value")};
}

void read_limits_of_value(const TomlTable& table, RegisterItem& item) {
  const auto sentinels = table.table("sentinels");
  for (const auto& why : sentinels.keys()) item.sentinels[why] = sentinels.number(why);
  if (table.has("lowest")) item.lowest = table.number("lowest");
  if (table.has("highest")) item.highest = table.number("highest");
  if (item.lowest && item.highest && *item.lowest > *item.highest)
    table.mistake("lowest", "\"lowest\" is above \"highest\"");
}

void read_addresses(const TomlTable& table, std::int64_t base, RegisterItem& item) {
  if (!table.is_table("address")) {
    item.address = read_address(table, "address", base);
    return;
  }
  const auto each = table.table("address");
  item.address = read_address(each, "tcp", base);
  item.rtu_address = read_address(each, "rtu", base);
}

RegisterItem read_item(const TomlTable& table, const ItemDefaults& defaults) {
  RegisterItem item;
  item.name = table.text("name");
  read_addresses(table, defaults.address_base, item);
  read_form(table, defaults.order, item);
  read_access(table, item);
  read_functions(table, defaults, item);
  read_limits_of_value(table, item);
  item.read_count = bounded<std::uint16_t>(table, "read_count", table.integer("read_count", 0), 0, 125);
  item.confidence = one_of(kConfidences, table, "confidence", "unverified");
  item.note = table.text("note", "");
  const auto last = std::max(item.address, item.rtu_address.value_or(0)) + word_count(item);
  if (last > 0x10000) table.mistake("address", fmt::format("\"{}\" does not fit below address 65536", item.name));
  return item;
}

/// Items that are alike, at equal distances: "alarm" becomes "alarm_1", "alarm_2", …
std::vector<RegisterItem> repeated(const TomlTable& table, const RegisterItem& item) {
  if (!table.has("count")) return {item};
  const auto count = bounded<int>(table, "count", table.integer("count"), 1, kMostOfOneKind);
  const auto spacing = bounded<int>(table, "spacing", table.integer("spacing"), 1, 4096);
  std::vector<RegisterItem> all;
  for (int i = 0; i < count; ++i) {
    auto& one = all.emplace_back(item);
    one.name = fmt::format("{}_{}", item.name, i + 1);
    const auto moved = [&](std::uint16_t address) {
      const int there = address + i * spacing;
      if (there + word_count(item) > 0x10000)
        table.mistake("count", fmt::format("\"{}\" does not fit below address 65536", one.name));
      return static_cast<std::uint16_t>(there);
    };
    one.address = moved(item.address);
    if (item.rtu_address) one.rtu_address = moved(*item.rtu_address);
  }
  return all;
}

/// The items that an item leans on.
void check_references(const TomlTable& table, const RegisterItem& item, const RegisterMap& map) {
  const auto must_be = [&](const char* key, const std::string& name, bool writable) {
    if (name.empty()) return;
    const auto* other = named_item(map, table, key, name);
    if (other && writable && !other->writable) table.mistake(key, fmt::format("register \"{}\" is not writable", name));
    if (other && !writable && !other->readable) table.mistake(key, fmt::format("register \"{}\" cannot be read", name));
  };
  must_be("decimals", item.decimals, false);
  must_be("unit_register", item.unit, false);
  must_be("seen_in", item.seen_in, false);
  for (const auto& name : item.also) must_be("also", name, true);
  if (!item.unit.empty()) {
    const auto* unit = map.find(item.unit);
    if (unit && !(unit->codes.contains("celsius") && unit->codes.contains("fahrenheit")))
      table.mistake("unit_register",
                    fmt::format("register \"{}\" has no codes \"celsius\" and \"fahrenheit\"", item.unit));
  }
  if (!item.companion) return;
  const auto* companion = named_item(map, table, "together_with", item.companion->item);
  if (companion && companion->address != item.address + word_count(item))
    table.mistake("together_with", fmt::format("register \"{}\" does not follow this one", companion->name));
}

void check_sizes(const TomlTable& table, const RegisterItem& item, const RegisterMap& map) {
  for (const auto& link : map.links)
    if (item.readable && word_count(item) > link.modbus.read_at_most)
      table.mistake("type", fmt::format("\"{}\" has {} registers, of which at most {} can be read at once", item.name,
                                        word_count(item), link.modbus.read_at_most));
}

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

std::uint16_t read_address(const TomlTable& table, const char* key, std::int64_t base) {
  return bounded<std::uint16_t>(table, key, table.integer(key) - base, 0, 65535);
}

void read_form(const TomlTable& table, WordOrder order, RegisterItem& item) {
  item.type = one_of(kTypes, table, "type");
  item.order = table.has("order") ? one_of(kWordOrders, table, "order") : order;
  if (item.type == RegisterType::text) read_text_form(table, item.text);
  if (item.type == RegisterType::date_time) read_date_form(table, item.date);
  if (item.type == RegisterType::bits) read_bits(table, item);
  read_scale(table, item);
  item.fahrenheit = table.choice("unit", {"°C", "°F"}, "°C") == "°F";
  item.step = table.boolean("difference", false);
  item.decimals = table.text("decimals", "");
  item.unit = table.text("unit_register", "");
  read_codes(table, item);
}

void read_items(const TomlTable& file, const ItemDefaults& defaults, RegisterMap& map) {
  std::set<std::string> names;
  const auto tables = file.tables("register");
  for (const auto& table : tables)
    for (auto& item : repeated(table, read_item(table, defaults))) {
      if (!names.insert(item.name).second)
        table.mistake("name", fmt::format("a second register is named \"{}\"", item.name));
      check_sizes(table, item, map);
      map.items.push_back(std::move(item));
    }
  for (const auto& table : tables)
    if (const auto* item = map.find(table.text("name", ""))) check_references(table, *item, map);
}

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

void read_sequences(const TomlTable& table, RegisterMap& map) {
  for (const auto& name : table.keys()) {
    if (std::find(kCommands.begin(), kCommands.end(), name) == kCommands.end())
      table.mistake(name, fmt::format("\"{}\" is none of {}", name, fmt::join(kCommands, ", ")));
    auto& steps = map.sequences[name];
    for (const auto& step : table.tables(name)) steps.push_back(read_step(step, map));
    if (steps.empty()) table.mistake(name, fmt::format("\"{}\" has no steps", name));
  }
}

}  // namespace gyrotherm::drivers
