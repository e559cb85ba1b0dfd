#include <fmt/format.h>

#include <algorithm>

#include "drivers/chamber/register_map_parts.hpp"

namespace gyrotherm {

namespace {

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

}  // namespace

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

}  // namespace gyrotherm
