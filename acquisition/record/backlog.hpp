// SPDX-License-Identifier: Apache-2.0
/// What was appended and is not yet acknowledged, within a bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "acquisition/record/row.hpp"

namespace gyrotherm::record {

using EntryPointer = std::shared_ptr<const Entry>;

/// Entries in order. Beyond `most` the oldest row that carries no event of the safety kinds becomes part of a gap that
/// says so (only if there is none such, the oldest row of all).
class Backlog {
 public:
  explicit Backlog(std::size_t most) : most_(most) {}

  void push(Entry entry);
  /// The oldest entries, at most so many: in flight until settled with acknowledge() or put_back(), and never dropped
  /// meanwhile.
  [[nodiscard]] std::vector<EntryPointer> take(std::size_t most);
  void acknowledge();
  void put_back() { in_flight_ = 0; }

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] std::size_t dropped() const { return dropped_; }  ///< rows, ever
  /// Seconds of the gaps in it that nothing was measured in: the disk is behind by none of them.
  [[nodiscard]] std::int64_t unmeasured() const { return unmeasured_; }

 private:
  using Droppable = bool (*)(const Entry&);
  bool drop_oldest(Droppable droppable);
  void drop(std::size_t at);

  std::size_t most_;
  std::deque<EntryPointer> entries_;
  std::size_t in_flight_{};
  std::size_t dropped_{};
  std::int64_t unmeasured_{};
};

/// The cause of the gap that dropped rows leave.
inline constexpr const char* kDropped = "dropped: the disk took no rows for longer than the memory holds them";

/// Interlocks, states, commands and ends: what must be in the record although the disk failed.
[[nodiscard]] bool carries_safety_event(const Entry& entry);

}  // namespace gyrotherm::record
