#include "drivers/chamber/map_confidence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace gyrotherm {

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

}  // namespace gyrotherm
