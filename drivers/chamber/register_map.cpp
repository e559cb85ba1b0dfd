// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/register_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/register_map_reader.hpp"

namespace gyrotherm::drivers {

namespace {

void check_required(const TomlTable& file, const RegisterMap& map) {
  const auto* air = map.find("air_temperature");
  const auto* set_point = map.find("set_point");
  if (!air) file.mistake("", "missing [[register]] named \"air_temperature\"");
  if (!set_point) file.mistake("", "missing [[register]] named \"set_point\"");
  if (air && !air->readable) file.mistake("", "register \"air_temperature\" cannot be read");
  if (set_point && !set_point->writable) file.mistake("", "register \"set_point\" must have access = \"rw\" or \"w\"");
  const auto is_number = [](const RegisterItem* item) {
    return !item || (item->type != RegisterType::text && item->type != RegisterType::date_time);
  };
  if (!is_number(air) || !is_number(set_point))
    file.mistake("", "registers \"air_temperature\" and \"set_point\" must be numbers");
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
    if (!item->readable) link.mistake("one_block", fmt::format("register \"{}\" cannot be read", name));
  }
  for (const auto& one : map.links)
    if (end - first > one.modbus.read_at_most)
      link.mistake("one_block", fmt::format("the block spans {} registers, expected at most {}", end - first,
                                            one.modbus.read_at_most));
}

constexpr int kMostReadAtOnce = 125, kMostWrittenAtOnce = 123;

/// A duration of zero or more that `link` may set anew.
void read_time(const TomlTable& link, const char* key, Duration& time) { time = link.duration(key, time); }

void read_serial(const TomlTable& link, SerialFormat& serial) {
  if (!link.has("serial")) return;
  const auto format = parse_serial_format(link.text("serial"));
  if (format)
    serial = *format;
  else
    link.mistake("serial", format.error().what);
}

/// What both [link] and the table of one link may say; the latter has the last word.
void read_settings(const TomlTable& link, ModbusLink& modbus) {
  modbus.unit = bounded<std::uint8_t>(link, "unit", link.integer("unit", modbus.unit), 0, 255);
  modbus.port = bounded<std::uint16_t>(link, "port", link.integer("port", modbus.port), 1, 65535);
  read_time(link, "timeout", modbus.timeout);
  constexpr Duration kLongest = std::chrono::seconds(2);  // three of them are less than the guard's patience
  if (modbus.timeout <= Duration::zero() || modbus.timeout > kLongest)
    link.mistake("timeout", "\"timeout\" is not within its bounds, expected more than zero and at most 2 s");
  read_time(link, "minimum_period", modbus.minimum_period);
  read_time(link, "after_write", modbus.after_write);
  read_time(link, "gap", modbus.gap);
  const auto limit = [&](const char* key, std::uint16_t& value, int most) {
    value = bounded<std::uint16_t>(link, key, link.integer(key, value), 1, most);
  };
  limit("read_at_most", modbus.read_at_most, kMostReadAtOnce);
  limit("write_at_most", modbus.write_at_most, kMostWrittenAtOnce);
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
  for (const double code : link.numbers("busy_exceptions"))
    modbus.busy_exceptions.push_back(static_cast<std::uint8_t>(std::clamp(code, 0.0, 255.0)));
}

constexpr Vocabulary<ChamberActivity, 13> kActivities{{{"off", ChamberActivity::off},
                                                       {"running", ChamberActivity::running},
                                                       {"program", ChamberActivity::program},
                                                       {"ramping", ChamberActivity::ramping},
                                                       {"soaking", ChamberActivity::soaking},
                                                       {"waiting", ChamberActivity::waiting},
                                                       {"holding", ChamberActivity::holding},
                                                       {"done", ChamberActivity::done},
                                                       {"alarm", ChamberActivity::alarm},
                                                       {"door_open", ChamberActivity::door_open},
                                                       {"emergency_stop", ChamberActivity::emergency_stop},
                                                       {"power_failure", ChamberActivity::power_failure},
                                                       {"unknown", ChamberActivity::unknown}}};
constexpr Vocabulary<AlarmSeverity, 3> kSeverities{
    {{"note", AlarmSeverity::note}, {"warning", AlarmSeverity::warning}, {"stop", AlarmSeverity::stop}}};

std::vector<std::int64_t> every_code(const RegisterItem& item) {
  std::vector<std::int64_t> all;
  for (const auto& [name, codes] : item.codes) all.insert(all.end(), codes.begin(), codes.end());
  return all;
}

/// The codes or bits of one meaning of the item.
void add_meaning(const TomlTable& table, const char* key, const RegisterItem& item, const std::string& meaning,
                 Condition& condition) {
  if (const auto codes = item.codes.find(meaning); codes != item.codes.end()) {
    condition.codes.insert(condition.codes.end(), codes->second.begin(), codes->second.end());
  } else if (const auto flag = item.flags.find(meaning); flag != item.flags.end()) {
    condition.bits |= 1U << flag->second;
  } else if (!meaning.empty() && meaning == item.otherwise) {
    condition.codes = every_code(item);
    condition.not_these = true;
  } else {
    table.mistake(key, fmt::format("register \"{}\" has no code named \"{}\"", item.name, meaning));
  }
}

std::vector<std::string> one_or_more(const TomlTable& table, const char* key) {
  if (table.is_list(key)) return table.texts(key);
  return {table.text(key)};
}

void read_numbers(const TomlTable& table, Condition& condition) {
  for (const double bit : table.numbers("bits")) {
    if (bit < 0 || bit > 31)
      table.mistake("bits", fmt::format("bit {} is none of 0 to 31", bit));
    else
      condition.bits |= 1U << static_cast<unsigned>(bit);
  }
  if (table.has("above")) condition.above = table.number("above");
}

}  // namespace

bool holds(const Condition& condition, double value) {
  if (condition.above) return value > *condition.above;
  const auto word = static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
  const auto is_it = [&](auto code) { return static_cast<double>(code) == value; };
  const bool one_of_them = (word & condition.bits) != 0 || std::ranges::any_of(condition.codes, is_it);
  return one_of_them != condition.not_these;
}

const RegisterItem* RegisterMap::find(std::string_view item) const {
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& other) { return other.name == item; });
  return found == items.end() ? nullptr : &*found;
}

const MapLink* RegisterMap::find(LinkKind kind) const {
  const auto found = std::ranges::find_if(links, [&](const auto& one) { return one.kind == kind; });
  return found == links.end() ? nullptr : &*found;
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
  map.model = parsed->text("model", map.name);
  map.firmware = parsed->text("firmware", "");
  map.source = parsed->text("source");
  const auto link = parsed->table("link");
  read_links(link, map);
  const auto defaults = read_item_defaults(link, word_order);
  read_items(*parsed, defaults, map);
  if (parsed->has("identity")) read_identity(parsed->table("identity"), map);
  if (parsed->has("control")) read_control(parsed->table("control"), map);
  read_sequences(parsed->table("sequence"), map);
  read_states(*parsed, map);
  read_alarms(*parsed, map);
  read_limits(parsed->table("limits"), map);
  read_forbidden(*parsed, defaults, map);
  if (parsed->has("profile_memory")) read_memory(parsed->table("profile_memory"), defaults, map);
  parsed->ignore("simulated");  // the simulator reads it
  check_required(*parsed, map);
  check_block(link, map);
  if (auto verdict = parsed->verdict(); !verdict) return failure(std::move(verdict.error()));
  const auto usual = map.links.front().kind;
  return on_link(std::move(map), usual);
}

Result<RegisterMap> on_link(RegisterMap map, LinkKind kind) {
  const auto* link = map.find(kind);
  if (!link) return failure(FaultKind::usage, map.name, fmt::format("its map describes no {} link", name(kind)));
  const bool was_rtu = map.link.kind != LinkKind::tcp, is_rtu = kind != LinkKind::tcp;
  for (auto& item : map.items)
    if (item.rtu_address && was_rtu != is_rtu) std::swap(item.address, *item.rtu_address);
  map.link = *link;
  return map;
}

Result<RegisterMap> on_line(RegisterMap map, const Line& line, std::optional<LinkKind> framing) {
  auto kind = map.links.front().kind;
  if (std::holds_alternative<SerialLine>(line)) kind = LinkKind::rtu;
  if (std::holds_alternative<TcpLine>(line)) kind = map.find(LinkKind::tcp) ? LinkKind::tcp : LinkKind::rtu_over_tcp;
  return on_link(std::move(map), framing.value_or(kind));
}

const char* name(LinkKind kind) {
  const auto found = std::ranges::find_if(kLinkKinds, [&](const auto& entry) { return entry.second == kind; });
  return found->first;
}

const char* name(Confidence confidence) {
  const auto found = std::ranges::find_if(kConfidences, [&](const auto& entry) { return entry.second == confidence; });
  return found->first;
}

ItemDefaults read_item_defaults(const TomlTable& link, std::optional<WordOrder> word_order) {
  ItemDefaults defaults;
  defaults.order = one_of(kWordOrders, link, "word_order", "abcd");
  if (word_order) defaults.order = *word_order;
  defaults.address_base = link.integer("address_base", 0);
  if (defaults.address_base < 0 || defaults.address_base > 400001)
    link.mistake("address_base", "expected the number that the file gives to the first register: 0, 1, 40001 …");
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
  map.status_every = bounded<int>(link, "status_every", link.integer("status_every", 1), 0, 3600);
  const auto add = [&](LinkKind kind, const TomlTable* own) {
    MapLink made{.kind = kind, .modbus = common};
    made.modbus.framing = kind == LinkKind::tcp ? ModbusLink::Framing::tcp : ModbusLink::Framing::rtu;
    if (own) {
      read_settings(*own, made.modbus);
      made.clients_at_most = bounded<int>(*own, "clients_at_most", own->integer("clients_at_most", 0), 0, 1000);
    }
    map.links.push_back(std::move(made));
  };
  for (const auto& [word, kind] : kLinkKinds) {
    if (!link.has(word)) continue;
    const auto own = link.table(word);
    add(kind, &own);
  }
  if (map.links.empty()) add(LinkKind::tcp, nullptr);
  if (const auto usual = link.text("usual", name(map.links.front().kind)); !usual.empty()) {
    const auto found = std::ranges::find_if(map.links, [&](const auto& one) { return usual == name(one.kind); });
    if (found == map.links.end())
      link.mistake("usual", fmt::format("this file has no [link.{}]", usual));
    else
      std::rotate(map.links.begin(), found, found + 1);
  }
  map.link = map.links.front();
  map.link.kind = LinkKind::tcp;  // of the addresses, until on_link() is asked
}

const RegisterItem* named_item(const RegisterMap& map, const TomlTable& table, const char* key,
                               const std::string& name) {
  const auto* item = map.find(name);
  if (!item) table.mistake(key, fmt::format("no register is named \"{}\"", name));
  return item;
}

std::optional<double> code_of(const RegisterItem& item, const std::string& meaning) {
  if (const auto code = item.codes.find(meaning); code != item.codes.end() && !code->second.empty())
    return static_cast<double>(code->second.front());
  if (const auto flag = item.flags.find(meaning); flag != item.flags.end())
    return static_cast<double>(std::uint32_t{1} << flag->second);
  return std::nullopt;
}

Condition read_condition(const TomlTable& table, const RegisterMap& map) {
  Condition condition;
  condition.item = table.text("register");
  const auto* item = named_item(map, table, "register", condition.item);
  const bool negated = table.has("is_not");
  const char* key = negated ? "is_not" : "is";
  if (table.has(key)) condition.meanings = one_or_more(table, key);
  if (item && !item->readable && item->type == RegisterType::text)
    table.mistake("register", fmt::format("register \"{}\" is no number", item->name));
  for (const auto& meaning : condition.meanings)
    if (item) add_meaning(table, key, *item, meaning, condition);
  if (negated) condition.not_these = !condition.not_these;
  read_numbers(table, condition);
  const bool says = !condition.meanings.empty() || condition.bits != 0 || condition.above;
  if (!says && item && !item->flags.empty())
    for (const auto& [name, bit] : item->flags) condition.bits |= 1U << bit;
  else if (!says)
    table.mistake("", "expected \"is\", \"is_not\", \"bits\" or \"above\"");
  return condition;
}

void read_identity(const TomlTable& table, RegisterMap& map) {
  Fingerprint print;
  print.item = table.text("register");
  const auto* item = named_item(map, table, "register", print.item);
  const bool is_text = item && item->type == RegisterType::text;
  if (is_text)
    print.pattern = table.text("pattern");
  else
    print.value = table.number("value");
  if (!is_text) print.mask = bounded<std::uint32_t>(table, "mask", table.integer("mask", 0xFFFFFFFF), 1, 0xFFFFFFFF);
  if (item && !item->readable) table.mistake("register", fmt::format("register \"{}\" cannot be read", item->name));
  map.identity = std::move(print);
}

void read_control(const TomlTable& table, RegisterMap& map) {
  ControlMode control;
  control.commanded = table.text("commanded");
  control.active = table.text("active", control.commanded);
  const auto* commanded = named_item(map, table, "commanded", control.commanded);
  (void)named_item(map, table, "active", control.active);
  if (commanded && !commanded->writable)
    table.mistake("commanded", fmt::format("register \"{}\" is not writable", commanded->name));
  const auto code = [&](const char* key) -> std::int64_t {
    const auto name = table.text(key, key);
    if (!commanded) return 0;
    if (const auto found = code_of(*commanded, name)) return static_cast<std::int64_t>(*found);
    table.mistake(key, fmt::format("register \"{}\" has no code named \"{}\"", commanded->name, name));
    return 0;
  };
  control.on = code("on");
  control.off = code("off");
  map.control = std::move(control);
}

void read_states(const TomlTable& file, RegisterMap& map) {
  for (const auto& table : file.tables("state"))
    map.states.push_back({one_of(kActivities, table, "activity"), read_condition(table, map)});
}

void read_alarms(const TomlTable& file, RegisterMap& map) {
  for (const auto& table : file.tables("alarm"))
    map.alarms.push_back(
        {one_of(kSeverities, table, "severity", "warning"), table.text("text", ""), read_condition(table, map)});
}

void read_limits(const TomlTable& table, RegisterMap& map) {
  auto& limits = map.limits;
  if (table.has("lowest")) limits.lowest = table.celsius("lowest");
  if (table.has("highest")) limits.highest = table.celsius("highest");
  if (limits.lowest && limits.highest && *limits.lowest >= *limits.highest)
    table.mistake("lowest", "the lowest set point is not below the highest");
  const auto item = [&](const char* key) {
    const auto name = table.text(key, "");
    const auto* found = name.empty() ? nullptr : named_item(map, table, key, name);
    if (found && !found->readable) table.mistake(key, fmt::format("register \"{}\" cannot be read", name));
    return name;
  };
  limits.lowest_item = item("lowest_register");
  limits.highest_item = item("highest_register");
  limits.fastest = table.rate("fastest", {});
  limits.every = table.duration("every", {});
}

void read_forbidden(const TomlTable& file, const ItemDefaults& defaults, RegisterMap& map) {
  for (const auto& table : file.tables("forbidden")) {
    Forbidden range;
    range.first = read_address(table, "first", defaults.address_base);
    range.last = table.has("last") ? read_address(table, "last", defaults.address_base) : range.first;
    range.why = table.text("why");
    if (range.last < range.first) table.mistake("last", "\"last\" is below \"first\"");
    for (const auto& item : map.items)
      if (item.writable && item.address <= range.last && item.address + word_count(item) > range.first)
        table.mistake("first", fmt::format("register \"{}\" lies here and is writable", item.name));
    map.forbidden.push_back(std::move(range));
  }
}

namespace {

/// Every item in use, each once, in the order of the map.
std::vector<const RegisterItem*> items_in_use(const RegisterMap& map) {
  std::vector<std::string> names{"air_temperature", "set_point", map.limits.lowest_item, map.limits.highest_item};
  if (map.identity) names.push_back(map.identity->item);
  if (map.control) names.insert(names.end(), {map.control->commanded, map.control->active});
  for (const auto& [command, steps] : map.sequences)
    for (const auto& step : steps) {
      names.insert(names.end(), {step.item, step.date_of});
      if (step.only_if) names.push_back(step.only_if->item);
    }
  for (const auto& rule : map.states) names.push_back(rule.when.item);
  for (const auto& rule : map.alarms) names.push_back(rule.when.item);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto* item = map.find(names[i])) {
      names.insert(names.end(), {item->decimals, item->unit, item->seen_in});
      names.insert(names.end(), item->also.begin(), item->also.end());
    }
  std::vector<const RegisterItem*> items;
  for (const auto& item : map.items)
    if (std::ranges::find(names, item.name) != names.end()) items.push_back(&item);
  return items;
}

std::string listed(const std::vector<Doubt>& all, Confidence confidence) {
  std::vector<std::string> names;
  for (const auto& doubt : all)
    if (doubt.confidence == confidence)
      names.push_back(doubt.note.empty() ? doubt.item : fmt::format("{} ({})", doubt.item, doubt.note));
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<Doubt> doubts(const RegisterMap& map) {
  std::vector<Doubt> all;
  for (const auto* item : items_in_use(map))
    if (item->confidence != Confidence::verified) all.push_back({item->name, item->confidence, item->note});
  if (map.memory && map.memory->confidence != Confidence::verified)
    all.push_back({"profile memory", map.memory->confidence, ""});
  std::ranges::stable_sort(all, [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
  return all;
}

std::string confidence_in_words(const RegisterMap& map) {
  const auto all = doubts(map);
  const auto count = [&](Confidence confidence) { return std::ranges::count(all, confidence, &Doubt::confidence); };
  const auto verified = std::ranges::count_if(
      items_in_use(map), [](const auto* item) { return item->confidence == Confidence::verified; });
  std::vector<std::string> parts;
  if (verified > 0) parts.push_back(fmt::format("{} verified", verified));
  if (const auto n = count(Confidence::manual); n > 0) parts.push_back(fmt::format("{} from the manual", n));
  if (const auto n = count(Confidence::secondary); n > 0)
    parts.push_back(fmt::format("{} from public sources: {}", n, listed(all, Confidence::secondary)));
  if (const auto n = count(Confidence::unverified); n > 0)
    parts.push_back(fmt::format("{} UNVERIFIED: {}", n, listed(all, Confidence::unverified)));
  return fmt::format("registers in use: {}", fmt::join(parts, "; "));
}

Kelvins set_point_tolerance(const RegisterMap& map) {
  constexpr double kTenth = 0.1;
  const auto* item = map.find("set_point");
  if (!item) return {kTenth};
  return {std::max({finest_step(*item), item->tolerance.value_or(0), kTenth})};
}

}  // namespace gyrotherm::drivers
