#include "drivers/chamber/read_plan.hpp"

#include <algorithm>
#include <tuple>

namespace gyrotherm {

ReadFunction read_function(const RegisterItem& item) {
  return item.read_function.value_or(ReadFunction::holding_registers);
}

ReadSpan span_of(const RegisterItem& item) {
  return {read_function(item), item.address, std::max(word_count(item), item.read_count)};
}

std::vector<ReadSpan> plan_reads(std::span<const RegisterItem* const> items, bool holes, std::uint16_t at_most) {
  std::vector<ReadSpan> wanted;
  for (const auto* item : items) wanted.push_back(span_of(*item));
  std::ranges::sort(wanted, [](const auto& a, const auto& b) {
    return std::tuple(a.function, a.first, -a.count) < std::tuple(b.function, b.first, -b.count);
  });
  std::vector<ReadSpan> plan;
  for (const auto& span : wanted) {
    const int end = span.first + span.count;
    const bool together = !plan.empty() && plan.back().function == span.function;
    if (together && end <= plan.back().first + plan.back().count) continue;
    if (together && holes && end - plan.back().first <= at_most)
      plan.back().count = static_cast<std::uint16_t>(end - plan.back().first);
    else
      plan.push_back(span);
  }
  return plan;
}

std::span<const std::uint16_t> Snapshot::words_of(const RegisterItem& item) const {
  const auto function = read_function(item);
  const int count = word_count(item);
  for (const auto& [span, words] : found_)
    if (span.function == function && item.address >= span.first && item.address + count <= span.first + span.count)
      return std::span(words).subspan(static_cast<std::size_t>(item.address - span.first),
                                      static_cast<std::size_t>(count));
  return {};
}

}  // namespace gyrotherm
