#include "drivers/chamber/register_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/toml_reader.hpp"
#include "drivers/chamber/register_map_parts.hpp"

namespace gyrotherm {

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

}  // namespace

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
  read_simulated(parsed->table("simulated"), map);
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

}  // namespace gyrotherm
