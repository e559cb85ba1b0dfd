// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/run_tally.hpp"

#include <fmt/format.h>

#include "acquisition/record/record.hpp"
#include "core/clock.hpp"

namespace gyrotherm::run {
namespace {

std::string format_count(std::int64_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string describe(const record::AlarmCount& alarms) {
  auto words = format_count(alarms.occurrences, "alarm", "alarms");
  if (alarms.occurrences > 1) words += fmt::format(" of {}", format_count(alarms.tags, "kind", "kinds"));
  if (alarms.unacknowledged > 0) words += fmt::format(" ({} unacknowledged)", alarms.unacknowledged);
  return words;
}

std::string describe_gaps(const RunTally& tally) {
  const auto words = format_count(tally.gaps, "gap", "gaps");
  return tally.gaps == 0 ? words
                         : fmt::format("{} of {} in all", words, format_duration(std::chrono::seconds(tally.gap_s)));
}

}  // namespace

void RunTally::count_state(RunState state) {
  suspended_s += state == RunState::suspended ? 1 : 0;
  held_s += state == RunState::held ? 1 : 0;
}

void RunTally::count_gap(std::int64_t first, std::int64_t last) {
  ++gaps;
  gap_s += last - first + 1;
}

RunTally count_tally(const record::Record& record, std::int64_t missing_readings, std::int64_t while_off) {
  RunTally tally{.faulty_readings = missing_readings - while_off, .readings_while_off = while_off};
  for (const auto state : record.state) tally.count_state(state);
  for (const auto& gap : record.gaps) tally.count_gap(gap.first, gap.last);
  return tally;
}

std::string describe_faults(std::int64_t faulty_readings, std::int64_t while_off) {
  auto words = format_count(faulty_readings, "faulty reading", "faulty readings");
  return while_off == 0 ? words : words + fmt::format(", {} missing while a unit was off", while_off);
}

std::string describe(const RunTally& tally, const record::AlarmCount& alarms) {
  return fmt::format("{}, {}, {} suspended, {} held, {}",
                     describe_faults(tally.faulty_readings, tally.readings_while_off), describe(alarms),
                     format_duration(std::chrono::seconds(tally.suspended_s)),
                     format_duration(std::chrono::seconds(tally.held_s)), describe_gaps(tally));
}

}  // namespace gyrotherm::run
