// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/recording_store.hpp"

#include <bit>

namespace gyrotherm::faults {

void LogHash::add(std::string_view text) {
  constexpr std::uint64_t kPrime = 0x100000001b3;
  for (const char c : text) hash_ = (hash_ ^ static_cast<unsigned char>(c)) * kPrime;
  hash_ = (hash_ ^ 0xFF) * kPrime;
}

void LogHash::add(std::int64_t number) {
  constexpr std::uint64_t kOdd = 0x9E3779B97F4A7C15;
  hash_ = (hash_ ^ static_cast<std::uint64_t>(number)) * kOdd;
  hash_ ^= hash_ >> 29;
}

void LogHash::add(double number) { add(std::bit_cast<std::int64_t>(number)); }

void LogHash::add(const Sample& sample) {
  add(sample.slot);
  add(sample.at.since_start.count());
  add(sample.at.utc.count());
  add(sample.chamber.value ? sample.chamber.value->air.value + 1000 * sample.chamber.value->set_point.value : 1e9);
  for (const auto& reading : sample.thermometers) add(reading.value ? reading.value->value : 1e9);
  for (const auto& unit : sample.units) {
    if (!unit.count.value)
      add(std::int64_t{-1});
    else
      for (const auto pulses : unit.count.value->pulses) add(pulses);
  }
  add(sample.progress.in_segment.count() + sample.progress.segment);
  add(sample.progress.soaked.count() + static_cast<int>(sample.state));
}

void LogHash::add(const Event& event) {
  add(event.at.since_start.count());
  add(static_cast<std::int64_t>(event.kind));
  add(event.text);
}

Result<void> RecordingStore::append(const Sample& sample, std::span<const Event> events) {
  sample_ = sample;
  events_.insert(events_.end(), events.begin(), events.end());
  hash_.add(sample);
  for (const auto& event : events) hash_.add(event);
  return store_->append(sample, events);
}

Result<void> RecordingStore::append_gap(std::int64_t first, std::int64_t last, const std::string& cause) {
  gaps_.push_back({first, last, cause});
  hash_.add(first);
  hash_.add(last);
  return store_->append_gap(first, last, cause);
}

Result<void> RecordingStore::append_event(const Event& event) {
  events_.push_back(event);
  hash_.add(event);
  return store_->append_event(event);
}

Result<void> RecordingStore::append_decision(const Event& event,
                                             std::span<const record::RunInfo::SegmentInfo> segments) {
  events_.push_back(event);
  hash_.add(event);
  return store_->append_decision(event, segments);
}

}  // namespace gyrotherm::faults
