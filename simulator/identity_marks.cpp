// SPDX-License-Identifier: Apache-2.0
#include "simulator/identity_marks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "drivers/chamber/expression_example.hpp"
#include "drivers/virtual_identity.hpp"

namespace gyrotherm::simulator {
namespace {

/// Returns whether a text ends in a decimal fraction. It is then a line of values in a fixed form, which other clients
/// parse to its end.
bool ends_in_fraction(std::string_view text) {
  const auto last = text.substr(text.find_last_of(" ,") + 1);
  const auto point = last.find('.');
  return point != std::string_view::npos && point > 0 && point + 1 < last.size() &&
         last.find_first_not_of("0123456789.") == std::string_view::npos;
}

/// Marks an item that contains a text, unless the item is too short. `print` is the pattern of the text, if it has one.
void mark_text(SimulatedUnit& unit, const drivers::RegisterItem& item, const drivers::Fingerprint* print) {
  const auto described =
      std::ranges::find_if(unit.initial_texts, [&](const auto& one) { return one.first == item.name; });
  std::string text;
  if (described != unit.initial_texts.end())
    text = described->second;
  else if (print != nullptr)
    text = drivers::make_example(*print).value_or("");
  if (ends_in_fraction(text)) return;
  text = text.empty() ? std::string(drivers::kVirtualSerialNumber) : drivers::add_virtual_mark(text);
  if (text.size() > item.text.characters || (print != nullptr && !drivers::fits(*print, text))) return;
  if (described != unit.initial_texts.end())
    described->second = text;
  else
    unit.initial_texts.emplace_back(item.name, text);
}

/// Marks the identity of an instrument with lines of text, unless its pattern excludes the mark.
void mark_line(std::string& identity, const drivers::RegisterMap& unit) {
  const auto marked = drivers::add_virtual_mark(identity);
  if (unit.identity && drivers::fits(*unit.identity, marked)) identity = marked;
}

}  // namespace

SimulatedUnit mark_identity(SimulatedUnit unit, const drivers::RegisterMap& map) {
  if (map.identity && !map.identity->pattern.empty()) mark_text(unit, *map.find(map.identity->item), &*map.identity);
  for (const auto& name : map.verification.shows) {
    const auto& item = *map.find(name);
    const bool is_long = item.type == drivers::RegisterType::s32 || item.type == drivers::RegisterType::u32;
    if (item.type == drivers::RegisterType::text) mark_text(unit, item, nullptr);
    if (is_long && name == "serial_number") unit.initial.emplace_back(name, drivers::kVirtualSerialInteger);
  }
  return unit;
}

void mark_identities(VirtualInstrumentsOptions& options) {
  for (auto& thermometer : options.thermometers) {
    thermometer.module_name = drivers::kShortVirtualName;
    if (thermometer.description) mark_line(thermometer.description->simulated.identity, thermometer.description->unit);
  }
  for (auto& supply : options.supplies) mark_line(supply.description.simulated.identity, supply.description.unit);
  for (auto& gyro : options.gyros)
    if (const auto& query = gyro.identity)
      gyro.commands.push_back(
          {.send = query->send,
           .wait = query->wait,
           .reply = fmt::format("{}{}{}", query->begins, drivers::kVirtualSerialNumber, query->ends)});
}

}  // namespace gyrotherm::simulator
