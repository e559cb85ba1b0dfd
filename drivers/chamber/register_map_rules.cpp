#include <fmt/format.h>

#include <algorithm>

#include "drivers/chamber/register_map_parts.hpp"

namespace gyrotherm {

namespace {

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

}  // namespace gyrotherm
