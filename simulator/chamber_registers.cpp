#include "simulator/chamber_registers.hpp"

#include <algorithm>
#include <utility>

namespace gyrotherm {

ChamberRegisters::ChamberRegisters(RegisterMap map, World& world) : map_(std::move(map)), world_(world) {
  block_begin_ = 0x10000;
  for (const auto& item : map_.items) {
    const auto meaning = meaning_of(item);
    const std::size_t words = word_count(item.type);
    for (std::size_t word = 0; word < words; ++word) {
      entries_[item.address + static_cast<int>(word)] = {&item, meaning, word};
    }
    const bool in_block = item.name == "air_temperature" || item.name == "set_point" || meaning == Meaning::fingerprint;
    if (!map_.one_block || !in_block) continue;
    block_begin_ = std::min<int>(block_begin_, item.address);
    block_end_ = std::max(block_end_, item.address + static_cast<int>(words));
  }
}

ChamberRegisters::Meaning ChamberRegisters::meaning_of(const RegisterItem& item) const {
  if (item.name == "air_temperature") return Meaning::air;
  if (item.name == "set_point" || item.name == "active_set_point") return Meaning::set_point;
  if (item.name == "output") return Meaning::output;
  if (map_.control && (item.name == map_.control->commanded || item.name == map_.control->active)) return Meaning::mode;
  if (map_.identity && item.name == map_.identity->item) return Meaning::fingerprint;
  return Meaning::nothing;
}

bool ChamberRegisters::is_hole_of_block(std::uint16_t address) const {
  return address >= block_begin_ && address < block_end_;
}

double ChamberRegisters::value(Meaning meaning) const {
  switch (meaning) {
    case Meaning::air: return world_.air_as_measured().value;
    case Meaning::set_point: return world_.set_point().value;
    case Meaning::output: return world_.output_percent();
    case Meaning::mode: return static_cast<double>(world_.is_on() ? map_.control->on : map_.control->off);
    case Meaning::fingerprint: return map_.identity->value;
    case Meaning::nothing: return 0;
  }
  return 0;
}

tl::expected<void, ModbusException> ChamberRegisters::read(std::uint16_t address, std::uint16_t count,
                                                           std::vector<std::uint16_t>& words) const {
  if (count == 0 || count > map_.read_at_most) return tl::unexpected(ModbusException::illegal_value);
  const RegisterItem* encoded = nullptr;
  std::vector<std::uint16_t> item_words;
  for (int at = address; at < address + count; ++at) {
    const auto entry = entries_.find(at);
    if (entry == entries_.end()) {
      if (!is_hole_of_block(static_cast<std::uint16_t>(at))) return tl::unexpected(ModbusException::illegal_address);
      words.push_back(0);
      continue;
    }
    const auto& [item, meaning, word] = entry->second;
    if (item != encoded) item_words = encode(*item, value(meaning));
    encoded = item;
    words.push_back(item_words[word]);
  }
  return {};
}

tl::expected<void, ModbusException> ChamberRegisters::write(std::uint16_t address,
                                                            std::span<const std::uint16_t> words) {
  std::vector<Assignment> assignments;
  for (std::size_t done = 0; done < words.size();) {
    const auto entry = entries_.find(address + static_cast<int>(done));
    if (entry == entries_.end()) return tl::unexpected(ModbusException::illegal_address);
    const auto& [item, meaning, word] = entry->second;
    const std::size_t count = word_count(item->type);
    if (!item->writable || word != 0 || words.size() - done < count) {
      return tl::unexpected(ModbusException::illegal_address);
    }
    const auto value = decode(*item, words.subspan(done, count));
    if (!value || !accepts({meaning, *value})) return tl::unexpected(ModbusException::illegal_value);
    assignments.push_back({meaning, *value});
    done += count;
  }
  for (const auto& assignment : assignments) apply(assignment);
  return {};
}

bool ChamberRegisters::accepts(const Assignment& assignment) const {
  const auto code = [&](std::int64_t known) { return assignment.value == static_cast<double>(known); };
  if (assignment.meaning == Meaning::set_point) return world_.accepts({assignment.value});
  if (assignment.meaning == Meaning::mode) return code(map_.control->on) || code(map_.control->off);
  return true;
}

void ChamberRegisters::apply(const Assignment& assignment) {
  if (assignment.meaning == Meaning::set_point) world_.command({assignment.value});
  if (assignment.meaning == Meaning::mode) {
    world_.switch_on(assignment.value == static_cast<double>(map_.control->on));
  }
}

}  // namespace gyrotherm
