#include "simulator/memory_image.hpp"

#include <algorithm>

#include "drivers/chamber/item_context.hpp"

namespace gyrotherm {

MemoryImage::MemoryImage(const RegisterMap& map, RegisterImage& registers) : map_(map), registers_(registers) {
  if (!map.memory) return;
  const auto& memory = *map.memory;
  const auto add = [&](const MemoryBlock& block, int steps, bool windowed) {
    ranges_.push_back({block.address, block.address + (steps - 1) * memory.stride + block.count - 1, windowed});
  };
  for (const auto& block : memory.header) add(block, 1, false);
  for (const auto& block : memory.footer) add(block, 1, false);
  const bool window = memory.stride == 0;
  for (const auto& block : memory.step) {
    const bool edits = std::ranges::any_of(block.cells, [](const auto& c) { return c.source == CellSource::step; });
    add(block, memory.steps_at_most, window && !edits);
    if (window && block.select) step_selector_ = block.address;
    for (const auto& cell : block.cells)
      if (window && cell.source == CellSource::kind)
        if (const auto end = cell.form.codes.find("end"); end != cell.form.codes.end())
          fresh_[block.address + cell.at] = static_cast<std::uint16_t>(end->second.front());
  }
}

const MemoryImage::Range* MemoryImage::range_of(int address) const {
  const auto found =
      std::ranges::find_if(ranges_, [&](const auto& r) { return address >= r.first && address <= r.last; });
  return found == ranges_.end() ? nullptr : &*found;
}

bool MemoryImage::holds(int address) const { return range_of(address) != nullptr; }

int MemoryImage::selected_step() const {
  return step_selector_ < 0 ? 0 : registers_.word(step_selector_) - map_.memory->first_step;
}

std::uint16_t MemoryImage::word_at(const Place& place) const {
  if (const auto found = window_.find(place); found != window_.end()) return found->second;
  const auto fresh = fresh_.find(place.second);
  return fresh == fresh_.end() ? registers_.word(place.second) : fresh->second;
}

std::uint16_t MemoryImage::word(int address) const {
  const auto* range = range_of(address);
  return range && range->windowed ? word_at({selected_step(), address}) : word_at({0, address});
}

void MemoryImage::set_word(int address, std::uint16_t word) {
  const auto* range = range_of(address);
  window_[{range && range->windowed ? selected_step() : 0, address}] = word;
}

Result<ChamberProgram> MemoryImage::program(Celsius from) const {
  if (!map_.memory) return failure(FaultKind::refused, "profile memory", "this controller has none");
  const auto& memory = *map_.memory;
  const auto words_of = [&](const MemoryBlock& block, int step) -> Result<std::vector<std::uint16_t>> {
    const bool window = memory.stride == 0 && step >= 0;
    std::vector<std::uint16_t> words;
    const int first = block.address + std::max(step, 0) * memory.stride;
    for (int i = 0; i < block.count; ++i) words.push_back(word_at({window ? step : 0, first + i}));
    return words;
  };
  const auto value_of = [&](const RegisterItem& item) -> Result<double> { return registers_.value(item); };
  const auto context = [&](const RegisterItem& form) {
    return context_of(map_, form, value_of).value_or(ItemContext{});
  };
  return decode_program(memory, from, words_of, context);
}

}  // namespace gyrotherm
