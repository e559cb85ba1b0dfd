// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/register_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "drivers/chamber/item_exchange.hpp"

namespace gyrotherm::drivers {

bool holds(const Condition& condition, double value) {
  if (condition.above) return (value > *condition.above) != condition.not_these;
  const auto word = lower_bits(value).value_or(0);
  const auto is_it = [&](auto code) { return static_cast<double>(code) == value; };
  const bool one_of_them = (word & condition.bits) != 0 || std::ranges::any_of(condition.codes, is_it);
  return one_of_them != condition.not_these;
}

Result<bool> evaluate(const Condition& condition, const RegisterItem& item, double value) {
  if (condition.bits != 0 && !lower_bits(value))
    return failure(FaultKind::corrupted, place(item),
                   fmt::format("reads {:g}, which has no bits; check its type", value));
  return holds(condition, value);
}

bool can_stop(const RegisterMap& map) { return map.control || map.sequences.contains("stop"); }

const RegisterItem* RegisterMap::find(std::string_view item) const {
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& other) { return other.name == item; });
  return found == items.end() ? nullptr : &*found;
}

const MapLink* RegisterMap::find(LinkKind kind) const {
  const auto found = std::ranges::find_if(links, [&](const auto& one) { return one.kind == kind; });
  return found == links.end() ? nullptr : &*found;
}

Result<RegisterMap> select_link(RegisterMap map, LinkKind kind) {
  const auto* link = map.find(kind);
  if (!link) {
    std::vector<std::string> kinds;
    for (const auto& one : map.links) kinds.emplace_back(name(one.kind));
    return failure(FaultKind::usage, map.name,
                   fmt::format("the map has no {} link, expected a line for {}", name(kind), fmt::join(kinds, " or ")));
  }
  const auto has_rtu_addresses = [](LinkKind one) { return one == LinkKind::rtu || one == LinkKind::rtu_over_tcp; };
  const bool was_rtu = has_rtu_addresses(map.link.kind), is_rtu = has_rtu_addresses(kind);
  for (auto& item : map.items)
    if (item.rtu_address && was_rtu != is_rtu) std::swap(item.address, *item.rtu_address);
  map.link = *link;
  return map;
}

Result<RegisterMap> select_link_for(RegisterMap map, const Line& line, std::optional<LinkKind> framing) {
  auto kind = map.links.front().kind;
  if (map.text_link) {
    if (std::holds_alternative<SerialLine>(line)) kind = LinkKind::text_serial;
    if (std::holds_alternative<TcpLine>(line))
      kind = map.find(LinkKind::text_tcp) ? LinkKind::text_tcp : LinkKind::text_serial;
    return select_link(std::move(map), framing.value_or(kind));
  }
  if (std::holds_alternative<SerialLine>(line)) kind = LinkKind::rtu;
  if (std::holds_alternative<TcpLine>(line)) kind = map.find(LinkKind::tcp) ? LinkKind::tcp : LinkKind::rtu_over_tcp;
  return select_link(std::move(map), framing.value_or(kind));
}

Result<RegisterMap> select_power_switch(RegisterMap map, const std::string& name) {
  if (name.empty()) return map;
  const auto found = std::ranges::find(map.power_switches, name, &PowerSwitch::name);
  if (found == map.power_switches.end()) {
    std::vector<std::string> names;
    for (const auto& one : map.power_switches) names.push_back(one.name);
    return failure(FaultKind::usage, map.name,
                   fmt::format("the map has no power switch \"{}\", expected one of: {}", name,
                               names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
  }
  const auto& [own_name, is_on, on, off] = *found;
  auto& start = map.sequences["start"];
  start.insert(start.begin(), on.begin(), on.end());
  auto& stop = map.sequences["stop"];
  stop.insert(stop.end(), off.begin(), off.end());
  auto is_off = is_on;
  is_off.not_these = !is_off.not_these;
  map.states.insert(map.states.begin(), {ChamberActivity::off, is_off});
  return map;
}

Result<void> check_parameters(const RegisterMap& map, const TextParameters& parameters) {
  for (const auto& [name, value] : parameters) {
    if (map.parameters.contains(name)) continue;
    std::vector<std::string> known;
    for (const auto& [own, its] : map.parameters) known.push_back(own);
    return failure(
        FaultKind::usage, name,
        fmt::format("the description of the {} {} has no parameter \"{}\", expected {}", map.vendor, map.name, name,
                    known.empty() ? "none" : fmt::format("one of: {}", fmt::join(known, ", "))));
  }
  return {};
}

Result<RegisterMap> select_humidity(RegisterMap map) {
  const auto is_readable = [&](const char* name) {
    const auto* item = map.find(name);
    return item != nullptr && item->readable;
  };
  if (!is_readable("humidity") && !is_readable("dew_point"))
    return failure(FaultKind::usage, map.name, "the map has no item \"humidity\" or \"dew_point\" that can be read");
  map.reads_humidity = true;
  return map;
}

Result<RegisterMap> apply_settings(RegisterMap map, const LinkSettings& settings) {
  const bool is_lines = is_text(map.link.kind);
  if (auto checked = is_lines ? check_text_settings(settings) : check_framing(map.link.modbus, settings); !checked)
    return failure(std::move(checked.error()));
  map.link.text.after_read = settings.after_read.value_or(map.link.text.after_read);
  map.link.text.after_write = settings.after_write.value_or(map.link.text.after_write);
  auto linked = apply_settings(std::move(map.link.modbus), settings);
  for (const auto& item : map.items)
    if (const auto size = std::max(item.read_count, word_count(item)); item.readable && size > linked.read_at_most)
      return failure(
          FaultKind::usage, "read_at_most",
          fmt::format("register \"{0}\" needs {1} registers in one exchange, expected at least {1}", item.name, size));
  map.link.modbus = std::move(linked);
  return map;
}

const char* name(LinkKind kind) { return keyword_for(kLinkKinds, kind); }
const char* name(Confidence confidence) { return keyword_for(kConfidences, confidence); }

namespace {

/// Returns the items in use (see list_doubts()), in the order of the map, each once.
std::vector<const RegisterItem*> find_items_in_use(const RegisterMap& map) {
  std::vector<std::string> names{"air_temperature", "set_point", map.limits.lowest_item, map.limits.highest_item};
  if (map.identity) names.push_back(map.identity->item);
  names.insert(names.end(), map.verification.shows.begin(), map.verification.shows.end());
  for (const auto& setting : map.verification.settings) names.push_back(setting.item);
  if (map.control) names.insert(names.end(), {map.control->commanded, map.control->active});
  for (const auto& [command, steps] : map.sequences)
    for (const auto& step : steps) {
      names.insert(names.end(), {step.item, step.date_of});
      if (step.only_if) names.push_back(step.only_if->item);
    }
  for (const auto& rule : map.states) names.push_back(rule.when.item);
  for (const auto& rule : map.alarms) names.push_back(rule.when.item);
  if (map.reads_humidity) names.insert(names.end(), {"humidity", "dew_point"});
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

std::string list_items(const std::vector<Doubt>& all, Confidence confidence) {
  std::vector<std::string> names;
  for (const auto& doubt : all)
    if (doubt.confidence == confidence)
      names.push_back(doubt.note.empty() ? doubt.item : fmt::format("{} ({})", doubt.item, doubt.note));
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<Doubt> list_doubts(const RegisterMap& map) {
  std::vector<Doubt> all;
  for (const auto* item : find_items_in_use(map))
    if (item->confidence != Confidence::verified) all.push_back({item->name, item->confidence, item->note});
  if (map.memory && map.memory->confidence != Confidence::verified)
    all.push_back({"profile memory", map.memory->confidence, ""});
  std::ranges::stable_sort(all, [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
  return all;
}

std::string describe_confidence(const RegisterMap& map) {
  const auto all = list_doubts(map);
  const auto count = [&](Confidence confidence) { return std::ranges::count(all, confidence, &Doubt::confidence); };
  const auto verified = std::ranges::count_if(
      find_items_in_use(map), [](const auto* item) { return item->confidence == Confidence::verified; });
  std::vector<std::string> parts;
  if (verified > 0) parts.push_back(fmt::format("{} verified", verified));
  if (const auto n = count(Confidence::manual); n > 0) parts.push_back(fmt::format("{} from the manual", n));
  if (const auto n = count(Confidence::secondary); n > 0)
    parts.push_back(fmt::format("{} from public sources: {}", n, list_items(all, Confidence::secondary)));
  if (const auto n = count(Confidence::unverified); n > 0)
    parts.push_back(fmt::format("{} UNVERIFIED: {}", n, list_items(all, Confidence::unverified)));
  return fmt::format("{} in use: {}", map.text_link ? "items" : "registers", fmt::join(parts, "; "));
}

Kelvins set_point_tolerance(const RegisterMap& map) {
  constexpr double kTenth = 0.1;
  const auto* item = map.find("set_point");
  if (!item) return {kTenth};
  return {std::max({finest_step(*item), item->tolerance.value_or(0), kTenth})};
}

namespace {

constexpr std::array kOrders{WordOrder::abcd, WordOrder::cdab, WordOrder::badc, WordOrder::dcba};
constexpr double kTinyC = 1e-4;
constexpr double kNearZeroC = 0.05;

double decode_in_order(RegisterItem item, WordOrder order, std::span<const std::uint16_t> words) {
  item.order = order;
  item.lowest.reset();
  item.highest.reset();
  const auto value = decode(item, words);
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

/// Returns whether a chamber can have this temperature. `least` is the minimum distance from zero of a non-zero value.
bool is_plausible(double value, double least) {
  constexpr double kLowestC = -200, kHighestC = 400;
  return value >= kLowestC && value <= kHighestC && (value == 0 || std::abs(value) >= least);
}

/// Returns whether both values are plausible. Two zeros are not, because they are equal in every order.
bool is_plausible(const OrderFinding& one, double least) {
  const bool shows_nothing = one.air_c == 0 && one.set_point_c == 0;
  return is_plausible(one.air_c, least) && is_plausible(one.set_point_c, least) && !shows_nothing;
}

std::string describe_order(const OrderFinding& one) {
  return fmt::format("{} (air {:.2f} °C, set point {:.2f} °C)", name(one.order), one.air_c, one.set_point_c);
}

}  // namespace

std::vector<OrderFinding> probe_word_order(const RegisterItem& air, std::span<const std::uint16_t> air_words,
                                           const RegisterItem& set_point,
                                           std::span<const std::uint16_t> set_point_words) {
  std::vector<OrderFinding> findings;
  if (word_count(air.type) < 2 || word_count(set_point.type) < 2) return findings;
  auto orders = kOrders;
  std::stable_partition(orders.begin(), orders.end(), [&](auto order) { return order == air.order; });
  for (const auto order : orders) {
    OrderFinding one{.order = order,
                     .air_c = decode_in_order(air, order, air_words),
                     .set_point_c = decode_in_order(set_point, order, set_point_words)};
    one.plausible = is_plausible(one, kNearZeroC);
    findings.push_back(one);
  }
  if (std::ranges::none_of(findings, &OrderFinding::plausible))
    for (auto& one : findings) one.plausible = is_plausible(one, kTinyC);
  return findings;
}

bool has_wrong_word_order(const std::vector<OrderFinding>& findings) {
  return !findings.empty() && !is_plausible(findings.front(), kTinyC) &&
         !(findings.front().air_c == 0 && findings.front().set_point_c == 0) &&
         std::ranges::any_of(findings, &OrderFinding::plausible);
}

std::string describe(const std::vector<OrderFinding>& findings) {
  if (findings.empty()) return "values in a single register have no word order";
  std::vector<std::string> matches;
  for (const auto& one : findings)
    if (one.plausible) matches.push_back(describe_order(one));
  if (matches.empty())
    return fmt::format("no word order gives a plausible air temperature and set point; the map's order gives {}",
                       describe_order(findings.front()));
  if (!findings.front().plausible)
    return fmt::format("the map's word order does not fit: {}; set word_order to {}", describe_order(findings.front()),
                       fmt::join(matches, " or "));
  if (matches.size() == 1) return "word order " + matches.front() + " fits; no other does";
  return fmt::format("word order {} fits, but so does {}: compare with the display", matches.front(),
                     fmt::join(matches.begin() + 1, matches.end(), ", "));
}

const char* name(WordOrder order) { return keyword_for(kWordOrders, order); }

}  // namespace gyrotherm::drivers
