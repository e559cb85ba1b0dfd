#include "drivers/chamber/chamber_status.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gyrotherm {

namespace {

/// "door_open" → "door open"
std::string in_words(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

/// The alarm in words: the rule's text, or the names of what the item holds.
std::string alarm_text(const AlarmRule& rule, const RegisterItem& item, double value) {
  if (!rule.text.empty()) return rule.text;
  if (item.flags.empty()) return fmt::format("{}: {}", in_words(item.name), in_words(meaning(item, value)));
  const auto word = static_cast<std::uint32_t>(static_cast<std::int64_t>(value)) & rule.when.bits;
  std::vector<std::string> names;
  for (const auto& [name, bit] : item.flags)
    if ((word >> bit & 1U) != 0) names.push_back(in_words(name));
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

ChamberStatus status_of(const RegisterMap& map, const ItemValue& value) {
  ChamberStatus status;
  for (const auto& rule : map.states) {
    const auto found = value(rule.when.item);
    if (!found || !holds(rule.when, *found)) continue;
    status.activity = rule.activity;
    break;
  }
  std::vector<std::pair<AlarmSeverity, std::string>> raised;
  for (const auto& rule : map.alarms) {
    const auto found = value(rule.when.item);
    if (found && holds(rule.when, *found))
      raised.emplace_back(rule.severity, alarm_text(rule, *map.find(rule.when.item), *found));
  }
  std::ranges::stable_sort(raised, [](const auto& a, const auto& b) { return a.first > b.first; });
  for (auto& [severity, text] : raised) {
    status.must_stop = status.must_stop || severity == AlarmSeverity::stop;
    status.alarms.push_back(std::move(text));
  }
  return status;
}

std::vector<const RegisterItem*> status_items(const RegisterMap& map) {
  std::vector<const RegisterItem*> items;
  const auto add = [&](const std::string& name) {
    const auto* item = map.find(name);
    if (item && item->readable && std::ranges::find(items, item) == items.end()) items.push_back(item);
  };
  for (const auto& rule : map.states) add(rule.when.item);
  for (const auto& rule : map.alarms) add(rule.when.item);
  return items;
}

bool matches(std::string_view pattern, std::string_view text) {
  const auto star = pattern.find('*');
  if (star == std::string_view::npos) return pattern == text;
  if (!text.starts_with(pattern.substr(0, star))) return false;
  pattern.remove_prefix(star + 1);
  for (std::size_t from = star; from <= text.size(); ++from)
    if (matches(pattern, text.substr(from))) return true;
  return false;
}

}  // namespace gyrotherm
