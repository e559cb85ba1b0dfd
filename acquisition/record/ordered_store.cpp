#include "acquisition/record/ordered_store.hpp"

#include <fmt/format.h>

#include <cassert>
#include <utility>

#include "acquisition/record/record_status.hpp"

namespace gyrotherm {
OrderedStore::OrderedStore(RunInfo info, RunStatus status)
    : info_(std::move(info)),
      status_(std::move(status)),
      before_(status_.frames.value_or(FrameCount{})),
      last_(status_.acknowledged) {}

Result<void> OrderedStore::follow_on(std::int64_t slot) const {
  if (slot == last_ + 1) return {};
  const std::string where = fmt::format("slot {}", slot);
  if (slot <= last_) return failure(FaultKind::storage, where, fmt::format("comes after slot {}", last_));
  return failure(FaultKind::storage, where,
                 fmt::format("slots {} to {} have neither a sample nor a gap", last_ + 1, slot - 1));
}

void OrderedStore::show(const Sample& sample) {
  status_.slot = sample.slot;
  status_.state = sample.state;
  const auto& frames = sample.gyro_frames;
  status_.frames = {before_.seen + frames.seen, before_.lost + frames.lost, before_.bad + frames.bad};
  show_progress(status_, info_, sample.progress);
  const auto chamber = value_of(sample.chamber);
  status_.chamber_air = chamber ? std::optional(chamber->air) : std::nullopt;
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    status_.thermometers[i].reading = value_of(sample.thermometers[i]);
}

Result<void> OrderedStore::append(const Sample& sample, std::span<const Event> events) {
  assert(sample.thermometers.size() == info_.thermometers.size());
  if (auto follows = follow_on(sample.slot); !follows) return follows;
  Entry entry = entry_of(sample, events, info_);
  const auto faults = static_cast<std::int64_t>(entry.missing.size());
  if (auto taken = take(std::move(entry)); !taken) return taken;
  last_ = sample.slot;
  status_.faults += faults;
  show(sample);
  return {};
}

Result<void> OrderedStore::append_gap(std::int64_t first, std::int64_t last, const std::string& cause) {
  assert(first <= last);
  if (auto follows = follow_on(first); !follows) return follows;
  auto taken = take(gap_entry(first, last, cause));
  if (taken) last_ = last;
  return taken;
}

void OrderedStore::publish(const Outlook& outlook) { show_outlook(status_, outlook); }

Result<void> OrderedStore::append_event(const Event& event) { return take(event_entry(last_, event)); }

}  // namespace gyrotherm
