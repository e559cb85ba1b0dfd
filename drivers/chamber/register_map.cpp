#include "drivers/chamber/register_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <set>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/description.hpp"

namespace gyrotherm {

namespace {

constexpr double kFinestOfFloat = 0.001;

constexpr Vocabulary<RegisterType, 5> kTypes{{{"u16", RegisterType::u16},
                                              {"s16", RegisterType::s16},
                                              {"u32", RegisterType::u32},
                                              {"s32", RegisterType::s32},
                                              {"f32", RegisterType::f32}}};
constexpr Vocabulary<WordOrder, 4> kOrders{
    {{"abcd", WordOrder::abcd}, {"cdab", WordOrder::cdab}, {"badc", WordOrder::badc}, {"dcba", WordOrder::dcba}}};
const std::vector<std::string> kConfidences{"verified", "manual", "secondary", "unverified"};

void read_link(const TomlTable& link, RegisterMap& map) {
  map.unit = bounded<std::uint8_t>(link, "unit", link.integer("unit", 1), 0, 255);
  map.port = bounded<std::uint16_t>(link, "port", link.integer("port", 502), 1, 65535);
  map.timeout = link.duration("timeout", std::chrono::milliseconds(500));
  if (map.timeout <= Duration::zero()) link.mistake("timeout", "\"timeout\" is zero, expected a positive duration");
  map.read_at_most = bounded<std::uint16_t>(link, "read_at_most", link.integer("read_at_most", 125), 1, 125);
  map.one_block = link.boolean("one_block", false);
}

RegisterItem read_item(const TomlTable& table, WordOrder order) {
  RegisterItem item;
  item.name = table.text("name");
  item.address = bounded<std::uint16_t>(table, "address", table.integer("address"), 0, 65535);
  item.type = one_of(kTypes, table, "type");
  item.order = table.has("order") ? one_of(kOrders, table, "order") : order;
  item.scale = table.number("scale", 1);
  if (item.scale <= 0) table.mistake("scale", fmt::format("\"scale\" is {}, expected a positive number", item.scale));
  item.resolution = table.number("resolution", item.type == RegisterType::f32 ? kFinestOfFloat : item.scale);
  if (item.resolution <= 0)
    table.mistake("resolution", fmt::format("\"resolution\" is {}, expected a positive number", item.resolution));
  item.writable = table.choice("access", {"r", "rw"}, "r") == "rw";
  item.confidence = table.choice("confidence", kConfidences, "unverified");
  const auto codes = table.table("codes");
  for (const auto& code : codes.keys()) item.codes[code] = codes.integer(code);
  if (item.address + word_count(item.type) > 0x10000)
    table.mistake("address", fmt::format("\"{}\" does not fit below address 65536", item.name));
  return item;
}

void read_items(const TomlTable& file, WordOrder order, RegisterMap& map) {
  std::set<std::string> names;
  for (const auto& table : file.tables("register")) {
    map.items.push_back(read_item(table, order));
    if (!names.insert(map.items.back().name).second)
      table.mistake("name", fmt::format("a second register is named \"{}\"", map.items.back().name));
  }
}

/// The item that `key` names.
const RegisterItem* named_item(const RegisterMap& map, const TomlTable& table, const char* key,
                               const std::string& name) {
  const auto* item = map.find(name);
  if (!item) table.mistake(key, fmt::format("no register is named \"{}\"", name));
  return item;
}

std::int64_t named_code(const RegisterItem* item, const TomlTable& table, const char* key) {
  const auto name = table.text(key, key);
  if (!item) return 0;
  const auto code = item->codes.find(name);
  if (code != item->codes.end()) return code->second;
  table.mistake(key, fmt::format("register \"{}\" has no code named \"{}\"", item->name, name));
  return 0;
}

void read_identity(const TomlTable& table, RegisterMap& map) {
  Fingerprint print{table.text("register"), table.number("value")};
  named_item(map, table, "register", print.item);
  map.identity = std::move(print);
}

void read_control(const TomlTable& table, RegisterMap& map) {
  ControlMode control;
  control.commanded = table.text("commanded");
  control.active = table.text("active", control.commanded);
  const auto* commanded = named_item(map, table, "commanded", control.commanded);
  named_item(map, table, "active", control.active);
  if (commanded && !commanded->writable)
    table.mistake("commanded", fmt::format("register \"{}\" is not writable", commanded->name));
  control.on = named_code(commanded, table, "on");
  control.off = named_code(commanded, table, "off");
  map.control = std::move(control);
}

void check_required(const TomlTable& file, const RegisterMap& map) {
  const auto* air = map.find("air_temperature");
  const auto* set_point = map.find("set_point");
  if (!air) file.mistake("", "missing [[register]] named \"air_temperature\"");
  if (!set_point) file.mistake("", "missing [[register]] named \"set_point\"");
  if (set_point && !set_point->writable) file.mistake("", "register \"set_point\" must have access = \"rw\"");
}

void check_block(const TomlTable& link, const RegisterMap& map) {
  int first = 0x10000, end = 0;
  for (const auto& name :
       {std::string("air_temperature"), std::string("set_point"), map.identity ? map.identity->item : ""}) {
    const auto* item = map.find(name);
    if (!item) continue;
    first = std::min<int>(first, item->address);
    end = std::max(end, item->address + word_count(item->type));
  }
  if (map.one_block && end - first > map.read_at_most)
    link.mistake("one_block",
                 fmt::format("the block spans {} registers, expected at most {}", end - first, map.read_at_most));
}

}  // namespace

const RegisterItem* RegisterMap::find(std::string_view item) const {
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& other) { return other.name == item; });
  return found == items.end() ? nullptr : &*found;
}

Result<RegisterMap> parse_register_map(std::string_view text, const std::string& file,
                                       std::optional<WordOrder> word_order) {
  const auto parsed = TomlTable::parse(text, file);
  if (!parsed) return failure(parsed.error());

  RegisterMap map;
  map.text = text;
  (void)parsed->choice("schema", {"gyrotherm-chamber/1"});
  map.name = parsed->text("name");
  map.vendor = parsed->text("vendor");
  map.source = parsed->text("source");
  const auto link = parsed->table("link");
  read_link(link, map);
  const auto order = one_of(kOrders, link, "word_order", "abcd");
  read_items(*parsed, word_order.value_or(order), map);
  if (parsed->has("identity")) read_identity(parsed->table("identity"), map);
  if (parsed->has("control")) read_control(parsed->table("control"), map);
  check_required(*parsed, map);
  check_block(link, map);
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  return map;
}

}  // namespace gyrotherm
