// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <set>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/exchange_time.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/chamber/text_forms.hpp"
#include "drivers/line/link_settings.hpp"

namespace gyrotherm::drivers {
namespace {

/// Default values for keys that an item does not have.
struct ItemDefaults {
  WordOrder order = WordOrder::abcd;
  std::int64_t address_base = 0;
  std::optional<ReadFunction> read_function;
  std::optional<WriteFunction> write_function;
};

constexpr double kFinestOfFloat = 0.001;

/// Assumed resolution if the number of decimals is read from the controller.
constexpr double kUsualDecimal = 0.1;
constexpr std::int64_t kMostOfOneKind = 256;

constexpr auto kTypes = make_vocabulary<RegisterType::u16, RegisterType::date_time>("u16", "s16", "u32", "s32", "f32",
                                                                                    "f64", "bits", "text", "date_time");
constexpr auto kDateParts =
    make_vocabulary<DatePart::year, DatePart::second>("year", "month", "day", "weekday", "hour", "minute", "second");

void read_text_form(const TomlTable& table, TextForm& form) {
  form.characters = whole<std::uint16_t>(table, "characters", 1, 125);
  form.per_register = whole<std::uint8_t>(table, "per_register", 1, 2, 2);
  form.low_byte_first = table.boolean("low_byte_first", false);
  form.stride = whole<std::uint16_t>(table, "stride", 1, 16, 1);
  form.padding = table.choice("padding", {"space", "zero"}, "space") == "zero" ? '\0' : ' ';
}

std::optional<DatePart> find_date_part(const TomlTable& table, const std::string& word) {
  for (const auto& [known, part] : kDateParts)
    if (word == known) return part;
  table.note_error("parts", fmt::format("\"{}\" is not one of year, month, day, weekday, hour, minute, second", word));
  return std::nullopt;
}

/// Reads ["year/month", "day/weekday", "hour/minute", "second"], with the high byte first.
void read_date_form(const TomlTable& table, DateForm& form) {
  for (const auto& word : table.texts("parts")) {
    const auto slash = word.find('/');
    const auto high = find_date_part(table, word.substr(0, slash));
    DateForm::Word parts{high.value_or(DatePart::year), std::nullopt};
    if (slash != std::string::npos) parts.low = find_date_part(table, word.substr(slash + 1));
    form.words.push_back(parts);
  }
  if (form.words.empty() || form.words.size() > 7)
    table.note_error("parts", "expected one to seven registers of parts");
  form.stride = whole<std::uint16_t>(table, "stride", 1, 16, 1);
  form.century = whole<int>(table, "century", 0, 2100, 0);
}

void read_bits(const TomlTable& table, RegisterItem& item) {
  item.first_bit = whole<std::uint8_t>(table, "bit", 0, 15);
  item.bit_count = whole<std::uint8_t>(table, "width", 1, 16 - item.first_bit, 1);
}

void read_scale(const TomlTable& table, RegisterItem& item) {
  const auto positive = [&](const char* key, double value) {
    if (value <= 0) table.note_error(key, fmt::format("\"{}\" is {}, expected a positive number", key, value));
    return value > 0 ? value : 1;
  };
  item.scale = positive("scale", table.number("scale", 1));
  item.offset = table.number("offset", 0);
  if (table.has("write_scale")) item.write_scale = positive("write_scale", table.number("write_scale"));
  double finest = std::max(item.scale, item.write_scale.value_or(0));
  if (table.has("decimals")) finest *= kUsualDecimal;
  const bool is_float = item.type == RegisterType::f32 || item.type == RegisterType::f64;
  item.resolution = positive("resolution", table.number("resolution", is_float ? kFinestOfFloat : finest));
}

void read_codes(const TomlTable& table, RegisterItem& item) {
  const auto codes = table.table("codes");
  for (const auto& name : codes.keys()) {
    auto& all = item.codes[name];
    if (codes.is_list(name))
      all = read_integers(codes, name.c_str(), -kLargestCode, kLargestCode);
    else
      all.push_back(codes.integer(name));
    if (all.empty()) codes.note_error(name, fmt::format("\"{}\" has no code", name));
  }
  const auto flags = table.table("flags");
  for (const auto& name : flags.keys())
    item.flags[name] =
        bounded<std::uint8_t>(flags, name.c_str(), flags.integer(name), 0, word_count(item.type) * 16 - 1);
  const bool words = item.type == RegisterType::u16 || item.type == RegisterType::u32;
  if (!item.flags.empty() && !words) table.note_error("flags", "flags are bits of a u16 or u32");
  item.otherwise = table.text("otherwise", "");
}

/// Reads an address and converts it to that on the wire.
std::uint16_t read_address(const TomlTable& table, const char* key, std::int64_t base) {
  return bounded<std::uint16_t>(table, key, table.integer(key) - base, 0, 65535);
}

/// Reads the encoding of a value: type, order, scale, unit and codes.
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
  if (table.has("unit") && table.has("unit_register"))
    table.note_error("unit", "\"unit\" and \"unit_register\" exclude each other, expected one of them");
  read_codes(table, item);
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
  item.seen_within = table.duration("within", Duration{});
  item.seen_later = table.boolean("seen_later", false);
  if (item.seen_later && item.name != "set_point")
    table.note_error("seen_later", "allowed only for the register \"set_point\"");
  item.also = table.texts("also");
  for (const auto* key : {"seen_in", "tolerance", "within"})
    if (table.has(key) && (item.self_clearing || !item.writable))
      table.note_error(
          key, fmt::format("has no effect with access = \"{}\", because no written value is read back", access));
  if (!table.has("together_with")) return;
  const auto other = table.table("together_with");
  item.companion = Companion{other.text("register"), other.number("value")};
}

void read_limits_of_value(const TomlTable& table, RegisterItem& item) {
  const auto sentinels = table.table("sentinels");
  for (const auto& why : sentinels.keys()) item.sentinels[why] = sentinels.number(why);
  item.stray_zeros = table.boolean("stray_zeros", false);
  if (item.stray_zeros && item.name != "air_temperature")
    table.note_error("stray_zeros", "allowed only for the register \"air_temperature\"");
  if (table.has("lowest")) item.lowest = table.number("lowest");
  if (table.has("highest")) item.highest = table.number("highest");
  if (item.lowest && item.highest && *item.lowest > *item.highest)
    table.note_error("lowest", "\"lowest\" is above \"highest\"");
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
  // In the memory of programs, the last step may be written like another kind of step.
  if (auto shared = describe_shared_code(item); !shared.empty()) table.note_error("codes", std::move(shared));
  if (auto shared = describe_shared_bit(item); !shared.empty()) table.note_error("flags", std::move(shared));
  read_access(table, item);
  read_functions(table, defaults, item);
  read_limits_of_value(table, item);
  if (auto never = describe_unreachable_name(item); !never.empty())
    table.note_error(item.flags.empty() ? "codes" : "flags", std::move(never));
  item.read_count = whole<std::uint16_t>(table, "read_count", 0, 125, 0);
  item.confidence = one_of(kConfidences, table, "confidence", "unverified");
  item.note = table.text("note", "");
  const auto last = std::max(item.address, item.rtu_address.value_or(0)) + word_count(item);
  if (last > 0x10000) table.note_error("address", fmt::format("\"{}\" does not fit below address 65536", item.name));
  return item;
}

/// Returns equal items at equal distances: "alarm" becomes "alarm_1", "alarm_2", …
std::vector<RegisterItem> repeat_item(const TomlTable& table, const RegisterItem& item) {
  if (!table.has("count")) return {item};
  const auto count = whole<int>(table, "count", 1, kMostOfOneKind);
  const auto spacing = whole<int>(table, "spacing", 1, 4096);
  std::vector<RegisterItem> all;
  for (int i = 0; i < count; ++i) {
    auto& one = all.emplace_back(item);
    one.name = fmt::format("{}_{}", item.name, i + 1);
    const auto shift = [&](std::uint16_t address) {
      const int shifted = address + i * spacing;
      if (shifted + word_count(item) > 0x10000)
        table.note_error("count", fmt::format("\"{}\" does not fit below address 65536", one.name));
      return static_cast<std::uint16_t>(shifted);
    };
    one.address = shift(item.address);
    if (item.rtu_address) one.rtu_address = shift(*item.rtu_address);
  }
  return all;
}

/// Notes an error for a number that the item cannot hold, which would be written as another one.
void check_can_hold(const TomlTable& table, const char* key, const RegisterItem& item, double value) {
  if (item.type == RegisterType::text || item.type == RegisterType::date_time)
    return table.note_error(key, fmt::format("register \"{}\" is not a number", item.name));
  if (!item.line.empty() || !item.decimals.empty() || !item.unit.empty()) return;  // known to the unit only
  const double held = decode_as_written(item, encode(item, value));
  if (!(std::abs(held - value) <= item.resolution / 2))
    table.note_error(
        key, fmt::format("register \"{}\" cannot hold {:g}; it would be written as {:g}", item.name, value, held));
}

/// Verifies the items that an item refers to.
void check_references(const TomlTable& table, const RegisterItem& item, const RegisterMap& map) {
  const auto must_be = [&](const char* key, const std::string& name, bool writable) {
    if (name.empty()) return;
    const auto* other = find_named_item(map, table, key, name);
    if (other && writable && !other->writable)
      table.note_error(key, fmt::format("register \"{}\" is not writable", name));
    if (other && !writable && !other->readable)
      table.note_error(key, fmt::format("register \"{}\" cannot be read", name));
  };
  must_be("decimals", item.decimals, false);
  must_be("unit_register", item.unit, false);
  must_be("seen_in", item.seen_in, false);
  for (const auto& name : item.also) must_be("also", name, true);
  if (!item.unit.empty()) {
    const auto* unit = map.find(item.unit);
    if (unit && !(unit->codes.contains("celsius") && unit->codes.contains("fahrenheit")))
      table.note_error("unit_register",
                       fmt::format("register \"{}\" has no codes \"celsius\" and \"fahrenheit\"", item.unit));
  }
  if (!item.companion) return;
  const auto* companion = find_named_item(map, table, "together_with", item.companion->item);
  if (companion && companion->address != item.address + word_count(item))
    table.note_error("together_with", fmt::format("register \"{}\" does not follow this one", companion->name));
  if (companion) check_can_hold(table, "together_with", *companion, item.companion->value);
}

void check_sizes(const TomlTable& table, const RegisterItem& item, const RegisterMap& map) {
  for (const auto& link : map.links)
    if (item.readable && word_count(item) > link.modbus.read_at_most)
      table.note_error("type", fmt::format("\"{}\" has {} registers, of which at most {} can be read at once",
                                           item.name, word_count(item), link.modbus.read_at_most));
}

void check_codes(const TomlTable& table, const MemoryCell& cell) {
  const auto must_have = [&](std::initializer_list<const char*> names) {
    for (const auto* name : names)
      if (!cell.form.codes.contains(name)) table.note_error("codes", fmt::format("no code is named \"{}\"", name));
  };
  if (cell.source == CellSource::kind) must_have({"ramp", "soak"});
  if (cell.source == CellSource::guaranteed_soak) must_have({"off", "on"});
}

MemoryCell read_cell(const TomlTable& table, const ItemDefaults& defaults) {
  MemoryCell cell;
  cell.at = whole<std::uint16_t>(table, "at", 0, 122, 0);
  cell.source = one_of(kCellSources, table, "holds", "constant");
  if (cell.source == CellSource::constant) cell.constant = table.number("value");
  read_form(table, defaults.order, cell.form);
  const bool is_text = cell.form.type == RegisterType::text;
  if (is_text != (cell.source == CellSource::name) || cell.form.type == RegisterType::date_time)
    table.note_error(
        "type", "expected type text for the program's name and a number for any other cell; no cell can be a date");
  check_codes(table, cell);
  return cell;
}

MemoryBlock read_block(const TomlTable& table, const ItemDefaults& defaults, const RegisterMap& map) {
  MemoryBlock block;
  block.address = read_address(table, "address", defaults.address_base);
  if (table.has("write_function")) block.function = one_of(kWriteFunctions, table, "write_function");
  for (const auto& word : table.texts("for"))
    for (const auto& [known, kind] : kStepKinds)
      if (word == known) block.kinds.push_back(kind);
  if (block.kinds.size() != table.texts("for").size()) table.note_error("for", "expected ramp, soak or end");
  block.select = table.boolean("select", false);
  block.read_back = !block.select && table.boolean("read_back", true);
  int end = 0;
  for (const auto& one : table.tables("cell")) {
    block.cells.push_back(read_cell(one, defaults));
    end = std::max(end, block.cells.back().at + word_count(block.cells.back().form));
  }
  if (block.cells.empty()) table.note_error("cell", "a block has at least one cell");
  block.count = whole<std::uint16_t>(table, "count", std::max(end, 1), 123, std::max(end, 1));
  for (const auto& link : map.links)
    if (block.count > link.modbus.write_at_most)
      table.note_error("count", fmt::format("{} registers, of which at most {} can be written at once", block.count,
                                            link.modbus.write_at_most));
  if (block.address + block.count > 0x10000) table.note_error("address", "the block does not fit below address 65536");
  return block;
}

constexpr Duration kUsualPatience = std::chrono::seconds(5);
const std::vector<std::string> kCommands{"prepare",      "start",        "stop",       "pause",
                                         "resume",       "acknowledge",  "advance",    "start_program",
                                         "stop_program", "begin_upload", "end_upload", "cancel_upload"};

/// Reads the value to write: a number, a code, a parameter of the command, or the time of another item.
void read_written_value(const TomlTable& table, const RegisterMap& map, const RegisterItem* item, SequenceStep& step) {
  if (table.has("code")) {
    const auto meaning = table.text("code");
    const auto code = item ? find_code(*item, meaning) : std::nullopt;
    if (item && !code) table.note_error("code", describe_unknown_code(map, *item, meaning));
    step.value = code.value_or(0);
  } else if (table.has("of")) {
    step.source = table.choice("of", {"program", "step"}) == "program" ? SequenceStep::Source::program
                                                                       : SequenceStep::Source::step;
    step.value = table.number("plus", 0);
  } else if (table.has("date_of")) {
    step.source = SequenceStep::Source::date;
    step.date_of = table.text("date_of");
    step.duration = table.duration("later", Duration{});
    const auto* clock = find_named_item(map, table, "date_of", step.date_of);
    if ((clock && clock->type != RegisterType::date_time) || (item && item->type != RegisterType::date_time))
      table.note_error("date_of", "both registers must be of type date_time");
  } else {
    // A text command may have no field for a value.
    step.value = table.number("value", map.text_link ? std::optional(0.0) : std::nullopt);
  }
  if (item && !map.text_link && step.source == SequenceStep::Source::number)
    check_can_hold(table, table.has("code") ? "code" : "value", *item, step.value);
}

SequenceStep read_step(const TomlTable& table, const RegisterMap& map) {
  SequenceStep step;
  if (table.has("when")) step.only_if = read_readable_condition(table.table("when"), map);
  if (table.has("write")) {
    step.kind = SequenceStep::Kind::write;
    step.item = table.text("write");
    const auto* item = find_named_item(map, table, "write", step.item);
    if (item && !item->writable)
      table.note_error("write", fmt::format("{} \"{}\" is not writable", item_kind(map), item->name));
    read_written_value(table, map, item, step);
  } else if (table.has("wait")) {
    step.kind = SequenceStep::Kind::wait;
    step.until = read_readable_condition(table.table("wait"), map);
    step.item = step.until.item;
    step.duration = table.duration("within", kUsualPatience);
  } else {
    step.kind = SequenceStep::Kind::pause;
    step.duration = table.duration("pause");
  }
  return step;
}

void read_items(const TomlTable& file, const ItemDefaults& defaults, RegisterMap& map) {
  std::set<std::string> names;
  const auto tables = file.tables("register");
  for (const auto& table : tables)
    for (auto& item : repeat_item(table, read_item(table, defaults))) {
      if (!names.insert(item.name).second)
        table.note_error("name", fmt::format("a second register is named \"{}\"", item.name));
      check_sizes(table, item, map);
      map.items.push_back(std::move(item));
    }
  for (const auto& table : tables)
    if (const auto* item = map.find(table.text("name", ""))) check_references(table, *item, map);
}

void read_memory(const TomlTable& table, const ItemDefaults& defaults, RegisterMap& map) {
  auto memory = read_memory_properties(table, map);
  memory.stride = whole<std::uint16_t>(table, "stride", 0, 1000, 0);
  for (const auto& block : table.tables("header")) memory.header.push_back(read_block(block, defaults, map));
  for (const auto& block : table.tables("step")) memory.step.push_back(read_block(block, defaults, map));
  for (const auto& block : table.tables("footer")) memory.footer.push_back(read_block(block, defaults, map));
  check_steps(table, memory);
  map.memory = std::move(memory);
}

void read_sequences(const TomlTable& table, RegisterMap& map) {
  for (const auto& name : table.keys()) {
    if (std::find(kCommands.begin(), kCommands.end(), name) == kCommands.end())
      table.note_error(name, fmt::format("\"{}\" is not one of {}", name, fmt::join(kCommands, ", ")));
    auto& steps = map.sequences[name];
    for (const auto& step : table.tables(name)) steps.push_back(read_step(step, map));
    if (steps.empty()) table.note_error(name, fmt::format("\"{}\" has no steps", name));
  }
}

Sequence read_steps(const TomlTable& table, const char* key, const RegisterMap& map) {
  Sequence steps;
  for (const auto& step : table.tables(key)) steps.push_back(read_step(step, map));
  if (steps.empty()) table.note_error(key, fmt::format("\"{}\" has no steps", key));
  return steps;
}

void read_power_switches(const TomlTable& file, RegisterMap& map) {
  for (const auto& table : file.tables("power")) {
    if (std::ranges::find(map.power_switches, table.text("name"), &PowerSwitch::name) != map.power_switches.end())
      table.note_error("name", fmt::format("a second power switch is named \"{}\"", table.text("name")));
    if (!map.sequences.contains("start") || !map.sequences.contains("stop"))
      table.note_error("name", "a power switch requires the commands \"start\" and \"stop\"");
    map.power_switches.push_back({.name = table.text("name"),
                                  .is_on = read_readable_condition(table, map),
                                  .on = read_steps(table, "on", map),
                                  .off = read_steps(table, "off", map)});
  }
}

void check_required(const TomlTable& file, const RegisterMap& map) {
  const auto* air = map.find("air_temperature");
  const auto* set_point = map.find("set_point");
  const auto* kind = map.text_link ? "item" : "[[register]]";
  if (!air) file.note_error("", fmt::format("missing {} named \"air_temperature\"", kind));
  if (!set_point) file.note_error("", fmt::format("missing {} named \"set_point\"", kind));
  const auto note = [&](const char* name, const char* of_register, const char* of_item) {
    if (!map.text_link) return file.note_error("", fmt::format("register \"{}\" {}", name, of_register));
    const auto tables = file.tables("item");
    const auto own = std::ranges::find_if(tables, [&](const auto& table) { return table.text("name", "") == name; });
    const bool is_empty = own != tables.end() && !own->has("ask") && !own->has("tell");
    if (is_empty) return;  // has an error already
    (own == tables.end() ? file : *own).note_error("", fmt::format("item \"{}\" {}", name, of_item));
  };
  if (air && !air->readable) note("air_temperature", "cannot be read", "has no \"ask\"");
  if (set_point && !set_point->writable)
    note("set_point", "must have access = \"rw\" or \"w\"",
         "has no \"tell\", expected an [[item]] of this name with the command");
  const auto is_number = [](const RegisterItem* item) {
    return !item || (item->type != RegisterType::text && item->type != RegisterType::date_time);
  };
  if (!is_number(air) || !is_number(set_point))
    file.note_error("", fmt::format("{}s \"air_temperature\" and \"set_point\" must be numbers", item_kind(map)));
}

void check_block(const TomlTable& link, const RegisterMap& map) {
  if (!map.one_block) return;
  int first = 0x10000, end = 0;
  for (const auto& name :
       {std::string("air_temperature"), std::string("set_point"), map.identity ? map.identity->item : ""}) {
    const auto* item = map.find(name);
    if (!item) continue;
    first = std::min<int>(first, item->address);
    end = std::max(end, item->address + word_count(*item));
    if (!item->readable) link.note_error("one_block", fmt::format("register \"{}\" cannot be read", name));
  }
  for (const auto& one : map.links)
    if (end - first > one.modbus.read_at_most)
      link.note_error("one_block", fmt::format("the block spans {} registers, expected at most {}", end - first,
                                               one.modbus.read_at_most));
}

constexpr int kMostWrittenAtOnce = 123;

/// Reads a non-negative duration that `link` may override.
void read_duration(const TomlTable& link, const char* key, Duration& time) {
  time = link.duration(key, time);
  check_longest(link, key, time, kMaxPause);
}

void read_serial(const TomlTable& link, SerialFormat& serial) {
  if (!link.has("serial")) return;
  const auto format = parse_serial_format(link.text("serial"));
  if (format)
    serial = *format;
  else
    link.note_error("serial", format.error().what);
}

/// Reads the keys that [link] and the table of a single link have in common. The table of the single link has
/// precedence.
void read_settings(const TomlTable& link, ModbusLink& modbus) {
  const auto settings = read_link_settings(link);
  if (settings.after_read) link.note_error("after_read", "unknown key \"after_read\"");
  modbus = apply_settings(std::move(modbus), settings);
  modbus.port = whole<std::uint16_t>(link, "port", 1, 65535, modbus.port);
  read_duration(link, "minimum_period", modbus.minimum_period);
  read_duration(link, "gap", modbus.gap);
  modbus.write_at_most = whole<std::uint16_t>(link, "write_at_most", 1, kMostWrittenAtOnce, modbus.write_at_most);
  modbus.answers_reads_by_either_function =
      link.boolean("answers_reads_by_either_function", modbus.answers_reads_by_either_function);
  modbus.loop_back = link.boolean("loop_back", modbus.loop_back);
  read_serial(link, modbus.serial);
}

void read_exceptions(const TomlTable& link, ModbusLink& modbus) {
  const auto names = link.table("exceptions");
  for (const auto& key : names.keys()) {
    const auto code = bounded<std::uint8_t>(names, key.c_str(), names.integer(key), 1, 255);
    modbus.exception_names[code] = key;
  }
  if (!link.has("busy_exceptions")) return;
  modbus.busy_exceptions.clear();
  for (const auto code : read_integers(link, "busy_exceptions", 1, 255))
    modbus.busy_exceptions.insert(static_cast<std::uint8_t>(code));
}

constexpr auto kActivities = make_vocabulary<ChamberActivity::off, ChamberActivity::unknown>(
    "off", "running", "not_following", "program", "ramping", "soaking", "waiting", "holding", "done", "alarm",
    "door_open", "emergency_stop", "power_failure", "unknown");
constexpr auto kSeverities = make_vocabulary<AlarmSeverity::note, AlarmSeverity::stop>("note", "warning", "stop");

/// Refuses states and alarms that would never be read.
void check_status_is_read(const TomlTable& link, const RegisterMap& map) {
  if (map.status_every > 0 || (map.states.empty() && map.alarms.empty())) return;
  link.note_error("status_every", "0 leaves every [[state]] and [[alarm]] without effect; expected 1 or more");
}

ItemDefaults read_item_defaults(const TomlTable& link, std::optional<WordOrder> word_order) {
  ItemDefaults defaults;
  defaults.order = one_of(kWordOrders, link, "word_order", "abcd");
  if (word_order) defaults.order = *word_order;
  defaults.address_base = link.integer("address_base", 0);
  if (defaults.address_base < 0 || defaults.address_base > 400001)
    link.note_error("address_base", "expected the number that the file gives to the first register: 0, 1, 40001 …");
  if (link.has("read_function")) defaults.read_function = one_of(kReadFunctions, link, "read_function");
  if (link.has("write_function")) defaults.write_function = one_of(kWriteFunctions, link, "write_function");
  return defaults;
}

void read_links(const TomlTable& link, RegisterMap& map) {
  ModbusLink common;
  read_settings(link, common);
  read_exceptions(link, common);
  map.one_block = link.boolean("one_block", false);
  map.holes = link.boolean("holes", false);
  map.status_every = whole<int>(link, "status_every", 0, 3600, 1);
  const auto add = [&](LinkKind kind, const TomlTable* own) {
    MapLink made{.kind = kind, .modbus = common};
    made.modbus.framing = kind == LinkKind::tcp ? ModbusLink::Framing::tcp : ModbusLink::Framing::rtu;
    if (own) {
      read_settings(*own, made.modbus);
      (void)whole<int>(*own, "clients_at_most", 0, 1000, 0);  // documentation only
    }
    map.links.push_back(std::move(made));
  };
  for (const auto& [word, kind] : kLinkKinds) {
    if (is_text(kind) || !link.has(word)) continue;
    const auto own = link.table(word);
    add(kind, &own);
  }
  if (map.links.empty()) add(LinkKind::tcp, nullptr);
  if (const auto usual = link.text("usual", name(map.links.front().kind)); !usual.empty()) {
    const auto found = std::ranges::find_if(map.links, [&](const auto& one) { return usual == name(one.kind); });
    if (found == map.links.end())
      link.note_error("usual", fmt::format("this file has no [link.{}]", usual));
    else
      std::rotate(map.links.begin(), found, found + 1);
  }
  map.link = map.links.front();
  // The addresses are for TCP until select_link() changes them.
  map.link.kind = LinkKind::tcp;
}

void read_control(const TomlTable& table, RegisterMap& map) {
  ControlMode control;
  control.commanded = table.text("commanded");
  control.active = table.text("active", control.commanded);
  const auto* commanded = find_named_item(map, table, "commanded", control.commanded);
  (void)find_named_item(map, table, "active", control.active);
  if (commanded && !commanded->writable)
    table.note_error("commanded", fmt::format("{} \"{}\" is not writable", item_kind(map), commanded->name));
  const auto code = [&](const char* key) -> std::int64_t {
    const auto name = table.text(key, key);
    if (!commanded) return 0;
    if (const auto found = find_code(*commanded, name)) return static_cast<std::int64_t>(*found);
    table.note_error(key, describe_unknown_code(map, *commanded, name));
    return 0;
  };
  control.on = code("on");
  control.off = code("off");
  map.control = std::move(control);
}

void read_states(const TomlTable& file, RegisterMap& map) {
  for (const auto& table : file.tables("state"))
    map.states.push_back({one_of(kActivities, table, "activity"), read_readable_condition(table, map)});
}

void read_alarms(const TomlTable& file, RegisterMap& map) {
  for (const auto& table : file.tables("alarm"))
    map.alarms.push_back({one_of(kSeverities, table, "severity", "warning"), table.text("text", ""),
                          read_readable_condition(table, map)});
}

void read_limits(const TomlTable& table, RegisterMap& map) {
  auto& limits = map.limits;
  if (table.has("lowest")) limits.lowest = table.celsius("lowest");
  if (table.has("highest")) limits.highest = table.celsius("highest");
  if (limits.lowest && limits.highest && *limits.lowest >= *limits.highest)
    table.note_error("lowest", "the lowest set point is not below the highest");
  const auto item = [&](const char* key) {
    const auto name = table.text(key, "");
    const auto* found = name.empty() ? nullptr : find_named_item(map, table, key, name);
    if (found && !found->readable) table.note_error(key, fmt::format("{} \"{}\" cannot be read", item_kind(map), name));
    return name;
  };
  limits.lowest_item = item(table.has("lowest_item") ? "lowest_item" : "lowest_register");
  limits.highest_item = item(table.has("highest_item") ? "highest_item" : "highest_register");
  (void)table.rate("fastest", CelsiusPerMinute{});  // documentation only
  limits.every = table.duration("every", Duration{});
  if (table.has("nonvolatile_set_point"))
    limits.nonvolatile = whole<std::int64_t>(table, "nonvolatile_set_point", 1, 1'000'000'000'000);
}

/// Reads the ranges of registers that must not be written. A writable item in such a range is an error.
void read_forbidden(const TomlTable& file, const ItemDefaults& defaults, const RegisterMap& map) {
  for (const auto& table : file.tables("forbidden")) {
    const auto first = read_address(table, "first", defaults.address_base);
    const auto last = table.has("last") ? read_address(table, "last", defaults.address_base) : first;
    (void)table.text("why");
    if (last < first) table.note_error("last", "\"last\" is below \"first\"");
    const auto is_inside = [&](const RegisterItem& item, int address) {
      return address <= last && address + word_count(item) > first;
    };
    for (const auto& item : map.items)
      if (item.writable && (is_inside(item, item.address) || is_inside(item, item.rtu_address.value_or(item.address))))
        table.note_error("first", fmt::format("register \"{}\" lies in this range and is writable", item.name));
  }
}

/// Reads the keys that every unit has. Returns the defaults for the keys of its items.
ItemDefaults read_any_unit(const TomlTable& file, std::optional<WordOrder> word_order, RegisterMap& map) {
  map.name = file.text("name");
  map.vendor = file.text("vendor");
  for (const auto* key : {"model", "firmware"}) (void)file.text(key, "");  // documentation only
  (void)file.text("source");
  const auto link = file.table("link");
  read_links(link, map);
  auto defaults = read_item_defaults(link, word_order);
  read_items(file, defaults, map);
  if (file.has("identity")) read_identity(file.table("identity"), map);
  return defaults;
}

}  // namespace

void read_unit(const TomlTable& file, std::optional<WordOrder> word_order, RegisterMap& map) {
  (void)read_any_unit(file, word_order, map);
}

ProfileMemory read_memory_properties(const TomlTable& table, const RegisterMap& map) {
  ProfileMemory memory;
  memory.steps_at_most = whole<int>(table, "steps_at_most", 1, 1000);
  memory.programs = whole<int>(table, "programs", 1, 1000, 1);
  memory.first_program = whole<int>(table, "first_program", 0, 1, 1);
  memory.first_step = whole<int>(table, "first_step", 0, 1, 1);
  memory.ramps_by_rate = table.choice("ramps_by", {"time", "rate"}, "time") == "rate";
  memory.end_step = table.boolean("end_step", false);
  memory.end_time = table.duration("end_time", Duration{});
  memory.longest_step = table.duration("longest_step");
  memory.finest = table.duration("finest", std::chrono::seconds(1));
  if (memory.finest <= Duration{} || memory.longest_step < memory.finest)
    table.note_error("longest_step", "expected a longest step that is not shorter than \"finest\", and both positive");
  memory.pause = table.duration("pause", Duration{});
  memory.recovery = table.duration("recovery", Duration{});
  memory.number_from = table.text("number_from", "");
  if (!memory.number_from.empty()) (void)find_named_item(map, table, "number_from", memory.number_from);
  memory.confidence = one_of(kConfidences, table, "confidence", "unverified");
  return memory;
}

void check_steps(const TomlTable& table, const ProfileMemory& memory) {
  const auto has = [&](CellSource source) {
    return std::ranges::any_of(memory.step, [&](const auto& block) {
      return std::ranges::any_of(block.cells, [&](const auto& cell) { return cell.source == source; });
    });
  };
  if (!has(CellSource::target) && !has(CellSource::start))
    table.note_error("step", "no cell of a step contains its target or its start");
  const bool has_time = has(CellSource::total_seconds) || (has(CellSource::hours) && has(CellSource::minutes));
  if (!has_time) table.note_error("step", "the cells of a step do not contain its time");
  if (memory.ramps_by_rate && !has(CellSource::rate)) table.note_error("step", "no cell of a step contains the rate");
  for (const auto& block : memory.step)
    if (block.address + (memory.steps_at_most - 1) * memory.stride + block.count > 0x10000)
      table.note_error("steps_at_most", "the last step does not fit below address 65536");
}

const char* item_kind(const RegisterMap& map) { return map.text_link ? "item" : "register"; }

const RegisterItem* find_named_item(const RegisterMap& map, const TomlTable& table, const char* key,
                                    const std::string& name) {
  const auto* item = map.find(name);
  if (!item) table.note_error(key, fmt::format("no {} is named \"{}\"", item_kind(map), name));
  return item;
}

Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file,
                                       std::optional<WordOrder> word_order, const TextParameters& parameters) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());

  RegisterMap map;
  map.text = text;
  const bool is_text_unit = parsed->choice("schema", {"gyrotherm-chamber/1", "gyrotherm-text/1"}) == "gyrotherm-text/1";
  ItemDefaults defaults;
  if (is_text_unit)
    read_text_unit(*parsed, parameters, map);
  else
    defaults = read_any_unit(*parsed, word_order, map);
  if (parsed->has("control")) read_control(parsed->table("control"), map);
  read_sequences(parsed->table("sequence"), map);
  read_power_switches(*parsed, map);
  read_states(*parsed, map);
  read_alarms(*parsed, map);
  check_status_is_read(parsed->table("link"), map);
  read_limits(parsed->table("limits"), map);
  if (is_text_unit) select_unsigned_fields(map);
  if (!is_text_unit) read_forbidden(*parsed, defaults, map);
  if (!is_text_unit && parsed->has("profile_memory")) read_memory(parsed->table("profile_memory"), defaults, map);
  parsed->ignore("simulated");  // read by the simulator
  check_required(*parsed, map);
  if (parsed->verdict())  // otherwise, a time may have an error of its own
    for (const auto& link : map.links)
      if (auto slow = describe_slow_exchange(link); !slow.empty())
        parsed->table("link").note_error("timeout", std::move(slow));
  check_block(parsed->table("link"), map);
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  const auto usual = map.links.front().kind;
  return select_link(std::move(map), usual);
}

}  // namespace gyrotherm::drivers
