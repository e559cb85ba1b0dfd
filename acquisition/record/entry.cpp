#include "acquisition/record/entry.hpp"

namespace gyrotherm {
namespace {

SampleRow row_of(const Sample& sample) {
  SampleRow row{.slot = sample.slot, .monotonic = sample.at.since_start, .utc = sample.at.utc};
  if (const auto& chamber = sample.chamber.value) {
    row.chamber_air_c = chamber->air.value;
    row.chamber_set_point_c = chamber->set_point.value;
  }
  row.thermometers_c.reserve(sample.thermometers.size());
  for (const auto& reading : sample.thermometers)
    row.thermometers_c.push_back(reading.value.value_or(Celsius{kMissing}).value);
  if (const auto& gyro = sample.gyro.value) {
    row.gyro = static_cast<double>(gyro->pulses);
    row.interval = gyro->interval;
  }
  row.progress = sample.progress;
  row.state = sample.state;
  return row;
}

template <class T>
void add_missing(Entry& entry, const std::string& channel, const Reading<T>& reading) {
  if (!reading.value) entry.missing.push_back({channel, reading.value.error()});
}

}  // namespace

Entry entry_of(const Sample& sample, std::span<const Event> events, const RunInfo& info) {
  Entry entry{.first = sample.slot, .last = sample.slot, .sample = row_of(sample)};
  entry.events.assign(events.begin(), events.end());
  if (!sample.chamber.value) add_missing(entry, "chamber", sample.chamber);
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    add_missing(entry, info.thermometers[i].name, sample.thermometers[i]);
  if (!sample.gyro.value) add_missing(entry, "gyro", sample.gyro);
  return entry;
}

Entry gap_entry(std::int64_t first, std::int64_t last, const std::string& cause) {
  return {.first = first, .last = last, .gap_cause = cause};
}

Entry event_entry(std::int64_t last, const Event& event) {
  return {.first = last + 1, .last = last, .events = {event}};
}

}  // namespace gyrotherm
