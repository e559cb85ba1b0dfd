// SPDX-License-Identifier: Apache-2.0
/// A closed record of one thermometer and a counting gyro. Their values are known functions of the second.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/record/store.hpp"
#include "apps/monitor/run_catalogue.hpp"

namespace gyrotherm::monitor {

inline record::RunInfo small_run_info() {
  record::RunInfo info;
  info.id = "0123456789abcdef0123456789abcdef";
  info.profile_name = "a profile";
  info.rig_name = "a rig";
  info.virtual_rig = true;
  info.started_utc = kVirtualEpoch;
  info.thermometers = {{"A", "a bridge", Kelvins{0}}};
  info.units = {{.axes = {{.kind = record::GyroKind::pulse_count, .scale = 0.1}}, .gradients = {"A"}}};
  info.segments = {{"hold", true, Celsius{20}, {}, -1}};
  return info;
}

/// Returns the sample of a second. The thermometer reads slot / 100 °C, or has a fault if `silent`. The gyro counts 50
/// pulses in 2 s.
inline Sample small_sample(std::int64_t slot, bool silent) {
  const Instant at{std::chrono::seconds(slot), kVirtualEpoch + std::chrono::seconds(slot)};
  const auto value = Celsius{static_cast<double>(slot) / 100};
  Sample sample;
  sample.slot = slot;
  sample.at = at;
  sample.chamber = {ChamberState{Celsius{20}, Celsius{21}}, at};
  sample.thermometers = {{value, at}};
  if (silent) sample.thermometers = {{failure(FaultKind::timeout, "A", "no reply"), at}};
  sample.units = {{.count = {GyroCount{{50}, std::chrono::seconds(2)}, at}}};
  sample.progress = {.segment = 0, .set_point = Celsius{20}};
  return sample;
}

/// Writes a finished record with the seconds 0 to `seconds` − 1 except `gap_first` to `gap_last`.
inline void write_small_run(const std::string& path, std::int64_t seconds, std::int64_t gap_first = -1,
                            std::int64_t gap_last = -1, const std::vector<std::int64_t>& silent = {}) {
  auto store = record::Store::create(path, small_run_info());
  ASSERT_TRUE(store) << text(store.error());
  for (std::int64_t slot = 0; slot < seconds; ++slot) {
    if (slot == gap_first) {
      ASSERT_TRUE((*store)->append_gap(gap_first, gap_last, "a test"));
    }
    if (slot >= gap_first && slot <= gap_last) continue;
    const bool is_silent = std::find(silent.begin(), silent.end(), slot) != silent.end();
    std::vector<Event> events;
    if (slot % 500 == 0)
      events.push_back({.at = {}, .kind = EventKind::note, .text = "second " + std::to_string(slot)});
    ASSERT_TRUE((*store)->append(small_sample(slot, is_silent), events));
  }
  ASSERT_TRUE((*store)->finish());
}

/// Returns the time of a row of the imported record: 10 s apart, with a gap of an hour before row 100.
inline Duration imported_time(std::int64_t row) { return std::chrono::seconds(10 * row + (row < 100 ? 0 : 3600)); }

/// Writes a record as an import does: its slots are row numbers, and it has no chamber, no profile and, unless
/// `started` is given, no date. The thermometer reads row / 100 °C. An event belongs to the last row.
inline void write_imported_run(const std::string& path, std::int64_t rows, Duration started = {}) {
  auto info = small_run_info();
  info.imported = true;
  info.virtual_rig = false;
  info.segments.clear();
  info.profile_name = "log.csv";
  info.started_utc = started;
  auto store = record::Store::create(path, info);
  ASSERT_TRUE(store) << text(store.error());
  for (std::int64_t row = 0; row < rows; ++row) {
    auto sample = small_sample(row, false);
    sample.at = {imported_time(row), started + imported_time(row)};
    sample.chamber = {failure(FaultKind::timeout, "chamber", "none"), sample.at};
    sample.progress.set_point = Celsius{std::numeric_limits<double>::quiet_NaN()};
    std::vector<Event> events;
    if (row + 1 == rows) events.push_back({.at = sample.at, .kind = EventKind::note, .text = "values of the file"});
    ASSERT_TRUE((*store)->append(sample, events));
  }
  ASSERT_TRUE((*store)->finish());
}

inline FoundRun found_in(const std::string& folder) {
  RunCatalogue catalogue({folder});
  catalogue.scan();
  const auto runs = catalogue.runs();
  EXPECT_EQ(runs.size(), 1u);
  return runs.empty() ? FoundRun{} : runs.front();
}

}  // namespace gyrotherm::monitor
