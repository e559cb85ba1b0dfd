/// What one call of Store puts into the record: the rows of a second, of a gap, or of an event that came alone.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// A row of the table `sample`; NaN or nothing is stored as NULL.
struct SampleRow {
  std::int64_t slot{};
  Duration monotonic{};
  std::optional<Duration> utc{};
  double chamber_air_c{kMissing};
  double chamber_set_point_c{kMissing};
  std::vector<double> thermometers_c{};
  double gyro{kMissing};
  std::optional<Duration> interval{};
  std::optional<ProfilePosition> progress{};
  std::optional<RunState> state{};
};

struct Entry {
  struct MissingReading {
    std::string channel;
    Fault fault;
  };
  std::int64_t first{};  ///< slots that it accounts for; none if after `last`
  std::int64_t last{};   ///< events belong to this one
  std::optional<SampleRow> sample{};
  std::string gap_cause{};  ///< where there is no sample
  std::vector<MissingReading> missing{};
  std::vector<Event> events{};

  [[nodiscard]] bool is_gap() const { return !sample && first <= last; }
  [[nodiscard]] std::int64_t slots() const { return last - first + 1; }
};

[[nodiscard]] Entry entry_of(const Sample& sample, std::span<const Event> events, const RunInfo& info);
[[nodiscard]] Entry gap_entry(std::int64_t first, std::int64_t last, const std::string& cause);
/// An event after slot `last`.
[[nodiscard]] Entry event_entry(std::int64_t last, const Event& event);

}  // namespace gyrotherm
