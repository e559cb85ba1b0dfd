// SPDX-License-Identifier: Apache-2.0
/// Totals for the summary of a run: faulty readings, suspended and held time, and gaps. Plain values; one thread.
#pragma once

#include <cstdint>
#include <string>

#include "acquisition/record/alarms.hpp"
#include "core/sample.hpp"

namespace gyrotherm::record {
struct Record;
}

namespace gyrotherm::run {

struct RunTally {
  std::int64_t faulty_readings{};
  /// Missing readings of units that the profile has switched off, in addition to the faulty ones.
  std::int64_t readings_while_off{};
  std::int64_t suspended_s{};
  std::int64_t held_s{};
  std::int64_t gaps{};
  std::int64_t gap_s{};
  bool operator==(const RunTally&) const = default;

  void count_state(RunState state);
  void count_gap(std::int64_t first, std::int64_t last);
};

/// Counts the rows and gaps of a record. `missing_readings` include those `while_off`. A resumed run continues from
/// there.
[[nodiscard]] RunTally count_tally(const record::Record& record, std::int64_t missing_readings, std::int64_t while_off);

/// Returns "17 faulty readings", or "17 faulty readings, 600 missing while a unit was off".
[[nodiscard]] std::string describe_faults(std::int64_t faulty_readings, std::int64_t while_off);

/// Returns "1700 faulty readings, 54 alarms of 3 kinds (1 unacknowledged), 10 min 02 s suspended, 0 s held, 2 gaps of
/// 14 s in all".
[[nodiscard]] std::string describe(const RunTally& tally, const record::AlarmCount& alarms);

}  // namespace gyrotherm::run
