// SPDX-License-Identifier: Apache-2.0
/// The entries that were appended and are not yet acknowledged. Their number is bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "acquisition/record/row.hpp"

namespace gyrotherm::record {

using EntryPointer = std::shared_ptr<const Entry>;

/// Keeps entries in order. If there are more than `most`, a row is dropped and becomes part of a gap whose cause is
/// kDropped: the oldest row without a safety event, or the oldest row if every row has one.
class Backlog {
 public:
  explicit Backlog(std::size_t most) : most_(most) {}

  void push(Entry entry);
  /// Returns the oldest entries, at most `most`. They are in flight until acknowledge() or put_back() is called, and
  /// are not dropped until then.
  [[nodiscard]] std::vector<EntryPointer> take(std::size_t most);
  /// Removes the entries in flight.
  void acknowledge();
  /// Returns the entries in flight to the queue.
  void put_back() { in_flight_ = 0; }

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  /// Returns the total number of samples dropped so far.
  [[nodiscard]] std::size_t dropped() const { return dropped_; }
  /// Returns the number of queued seconds that were appended as gaps. They do not count as a delay of the disk.
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

/// The cause of a gap made of dropped rows.
inline constexpr const char* kDropped = "dropped: the disk accepted no rows for longer than memory could hold them";

/// Returns whether an entry has an event that must be recorded even after a failure of the disk: interlocks, states,
/// commands, decisions, and the end of the run.
[[nodiscard]] bool carries_safety_event(const Entry& entry);

}  // namespace gyrotherm::record
