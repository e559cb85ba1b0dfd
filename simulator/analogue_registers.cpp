// SPDX-License-Identifier: Apache-2.0
#include "simulator/analogue_registers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "drivers/chamber/expression_example.hpp"
#include "drivers/chamber/item_exchange.hpp"
#include "drivers/chamber/status_turns.hpp"

namespace gyrotherm::simulator {
namespace {

tl::unexpected<Fault> wiring_fault(const std::string& what) {
  return failure(FaultKind::usage, "virtual analogue input", what);
}

}  // namespace

Result<AnalogueRegisters> AnalogueRegisters::make(VirtualAnalogueInput wired, const VirtualLaboratory& laboratory) {
  std::map<std::string, Source> sources;
  for (const auto& [input, unit, value, scale, offset] : wired.inputs) {
    if (input >= wired.map.inputs.size())
      return wiring_fault(fmt::format("{} has no input {}", wired.map.registers.name, input + 1));
    const auto& units = laboratory.units();
    const auto at = std::ranges::find(units, unit);
    if (at == units.end())
      return wiring_fault(fmt::format("\"{}\" is not one of the units {}", unit, fmt::join(units, ", ")));
    const auto unit_index = static_cast<std::size_t>(at - units.begin());
    const auto values = laboratory.values(unit_index);
    const auto found = std::ranges::find(values, value, &UnitValue::name);
    if (found == values.end())
      return wiring_fault(
          fmt::format("unit \"{}\" has no value \"{}\"; define it with [[virtual.value]]", unit, value));
    sources.emplace(wired.map.inputs[input].item,
                    Source{unit_index, static_cast<std::size_t>(found - values.begin()), scale, offset});
  }
  return AnalogueRegisters(std::move(wired.map), std::move(sources), laboratory);
}

std::vector<std::uint16_t> AnalogueRegisters::encode_words(const drivers::RegisterItem& item) const {
  if (const auto source = sources_.find(item.name); source != sources_.end()) {
    const auto& [unit, value, scale, offset] = source->second;
    return encode_as_read(item, (laboratory_->values(unit)[value].value - offset) / scale);
  }
  const auto is_status = [&](const auto& input) { return std::ranges::count(input.statuses, item.name) > 0; };
  if (std::ranges::any_of(map_.inputs, is_status))
    return encode_as_read(item, drivers::find_code(item, drivers::kNormalStatus).value_or(0));
  const auto& fingerprint = map_.registers.identity;
  if (fingerprint && fingerprint->item == item.name && item.type != drivers::RegisterType::text)
    return encode_as_read(item, fingerprint->value);
  if (fingerprint && fingerprint->item == item.name)
    return encode_text(item.text, drivers::make_example(*fingerprint).value_or(""));
  return std::vector<std::uint16_t>(word_count(item));
}

tl::expected<void, ModbusException> AnalogueRegisters::read(drivers::ReadFunction function, std::uint16_t address,
                                                            std::uint16_t count,
                                                            std::vector<std::uint16_t>& words) const {
  if (count == 0 || count > map_.registers.link.modbus.read_at_most)
    return tl::unexpected(ModbusException::illegal_value);
  const auto base = words.size();
  words.resize(base + count);
  std::vector<bool> served(count, map_.registers.holes);
  for (const auto& item : map_.registers.items) {
    const int from = item.address - address, to = from + word_count(item);
    if (!item.readable || drivers::read_span(item).function != function || to <= 0 || from >= count) continue;
    const auto own = encode_words(item);
    for (int at = std::max(from, 0); at < std::min<int>(to, count); ++at) {
      words[base + static_cast<std::size_t>(at)] = own[static_cast<std::size_t>(at - from)];
      served[static_cast<std::size_t>(at)] = true;
    }
  }
  if (std::ranges::find(served, false) == served.end()) return {};
  words.resize(base);
  return tl::unexpected(ModbusException::illegal_address);
}

}  // namespace gyrotherm::simulator
