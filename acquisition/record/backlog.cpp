// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/backlog.hpp"

#include <algorithm>
#include <utility>

#include "acquisition/record/decision.hpp"

namespace gyrotherm::record {
namespace {

bool is_safety(const Event& event) {
  switch (event.kind) {
    case EventKind::started:
    case EventKind::resumed:
    case EventKind::interlock:
    case EventKind::interrupted:
    case EventKind::finished:
    case EventKind::state:
    case EventKind::command:
    case EventKind::dropped:
    case EventKind::returned:
    case EventKind::acknowledged:
    case EventKind::told: return true;
    case EventKind::segment:
    case EventKind::fault:
    case EventKind::recovered:
    case EventKind::note: return false;
  }
  return false;
}

bool may_be_dropped(const Entry& entry) { return !entry.is_gap() && !carries_safety_event(entry); }
/// Later rows refer to the segments of a decision, so a decision is never dropped.
bool is_row(const Entry& entry) { return !entry.is_gap() && std::ranges::none_of(entry.events, is_decision); }

bool is_dropped_gap(const Entry& entry) { return entry.is_gap() && entry.gap_cause == kDropped; }

/// Returns the number of seconds of an entry that was appended as a gap; 0 for a row and for a gap made of dropped
/// rows.
std::int64_t unmeasured_in(const Entry& entry) { return entry.is_gap() && !is_dropped_gap(entry) ? entry.slots() : 0; }

}  // namespace

bool carries_safety_event(const Entry& entry) {
  return std::any_of(entry.events.begin(), entry.events.end(),
                     [](const Event& event) { return is_safety(event) || is_decision(event); });
}

void Backlog::push(Entry entry) {
  unmeasured_ += unmeasured_in(entry);
  entries_.push_back(std::make_shared<const Entry>(std::move(entry)));
  while (entries_.size() - in_flight_ > most_ && (drop_oldest(may_be_dropped) || drop_oldest(is_row))) {
  }
}

bool Backlog::drop_oldest(Droppable droppable) {
  for (std::size_t i = in_flight_; i < entries_.size(); ++i) {
    if (!droppable(*entries_[i])) continue;
    drop(i);
    return true;
  }
  return false;
}

/// Replaces a row by a gap. Merges it with adjacent gaps of dropped rows.
void Backlog::drop(std::size_t at) {
  const auto erase = [this](std::size_t i) { entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(i)); };
  const Entry& entry = *entries_[at];
  dropped_ += entry.sample ? 1 : 0;
  if (entry.slots() == 0) return erase(at);
  auto first = entry.first;
  auto last = entry.last;
  if (at + 1 < entries_.size() && is_dropped_gap(*entries_[at + 1])) {
    last = entries_[at + 1]->last;
    erase(at + 1);
  }
  if (at > in_flight_ && is_dropped_gap(*entries_[at - 1])) {
    first = entries_[at - 1]->first;
    erase(--at);
  }
  entries_[at] = std::make_shared<const Entry>(gap_entry(first, last, kDropped));
}

std::vector<EntryPointer> Backlog::take(std::size_t most) {
  in_flight_ = std::min(most, entries_.size());
  return {entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(in_flight_)};
}

void Backlog::acknowledge() {
  const auto end = entries_.begin() + static_cast<std::ptrdiff_t>(in_flight_);
  std::for_each(entries_.begin(), end, [this](const auto& entry) { unmeasured_ -= unmeasured_in(*entry); });
  entries_.erase(entries_.begin(), end);
  in_flight_ = 0;
}

}  // namespace gyrotherm::record
