/// Which registers one look at several items reads, and what it found. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "drivers/chamber/register_item.hpp"

namespace gyrotherm {

/// Registers that are read by one exchange.
struct ReadSpan {
  ReadFunction function{};
  std::uint16_t first{};
  std::uint16_t count{};
  bool operator==(const ReadSpan&) const = default;
};

[[nodiscard]] ReadFunction read_function(const RegisterItem& item);
/// The span of one item.
[[nodiscard]] ReadSpan span_of(const RegisterItem& item);
/// Spans of `items`, each item's registers in one; in order of function and address. With `holes`, spans are merged,
/// with what lies between them, as long as they are no longer than `at_most`.
[[nodiscard]] std::vector<ReadSpan> plan_reads(std::span<const RegisterItem* const> items, bool holes,
                                               std::uint16_t at_most);

/// Words as they were found.
class Snapshot {
 public:
  void clear() { found_.clear(); }
  void add(const ReadSpan& span, std::vector<std::uint16_t> words) { found_.push_back({span, std::move(words)}); }
  /// The words of an item, or none if they were not read.
  [[nodiscard]] std::span<const std::uint16_t> words_of(const RegisterItem& item) const;

 private:
  struct Found {
    ReadSpan span;
    std::vector<std::uint16_t> words;
  };
  std::vector<Found> found_;
};

}  // namespace gyrotherm
