// SPDX-License-Identifier: Apache-2.0
/// Display of the current second by `run` and `resume`: on a terminal a few lines that are redrawn in place, otherwise
/// one line per minute, nothing with --quiet. Also the second as JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/rate_meter.hpp"
#include "acquisition/record/run_info.hpp"
#include "apps/console/console.hpp"
#include "core/clock.hpp"
#include "core/sample.hpp"
#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Measures the bias of one axis: the rate minus the known part of the Earth rate.
class BiasMeter {
 public:
  /// Measures the axis numbered `index` of its unit.
  explicit BiasMeter(const record::AxisInfo& axis, std::size_t index = 0) : meter_(axis, index) {}
  void add_reading(const Reading<GyroCount>& reading) { meter_.add(reading); }
  [[nodiscard]] std::optional<DegreesPerHour> last_second() const { return subtract_earth_rate(meter_.last_second()); }
  /// Returns the mean over all seconds with a reading among the last 100 s, or nothing if there is none.
  [[nodiscard]] std::optional<DegreesPerHour> mean() const { return subtract_earth_rate(meter_.mean()); }

 private:
  [[nodiscard]] std::optional<DegreesPerHour> subtract_earth_rate(std::optional<DegreesPerHour> rate) const;

  record::RateMeter meter_;
};

class Display {
 public:
  /// Console, profile and rig must outlive the object. `is_simulated` marks the headline of a run as SIMULATED.
  Display(Console& console, const profile::Profile& profile, const rig::RigFile& rig, bool is_simulated);

  /// Adds the readings of a second. Must be called for each second.
  void add_sample(const Sample& sample);
  /// Shows the present state, after each second or each batch of seconds.
  void show(const Sample& sample, const RunOverview& overview, std::span<const record::Alarm> alarms,
            const std::string& goal = {});

  /// Returns the lines for a terminal, for the newest second. `alarms` are sorted from new to old. `goal` describes the
  /// progress of a run that ends by itself; empty for another run.
  [[nodiscard]] std::vector<std::string> lines(const Sample& sample, const RunOverview& overview,
                                               std::span<const record::Alarm> alarms = {},
                                               const std::string& goal = {}) const;
  /// Returns the wall-clock time until the end. For a virtual rig it is extrapolated from the speed so far. Returns
  /// nothing while the speed is unknown.
  [[nodiscard]] std::optional<Duration> time_left(const Sample& sample, const RunOverview& overview) const;

 private:
  [[nodiscard]] std::string unit_line(std::size_t unit) const;
  [[nodiscard]] std::string headline(const Sample& sample, const RunOverview& overview) const;
  [[nodiscard]] std::string clock_line(const Sample& sample, const RunOverview& overview) const;
  [[nodiscard]] std::vector<std::string> temperature_lines(const Sample& sample) const;

  Console& console_;
  const profile::Profile& profile_;
  const rig::RigFile& rig_;
  bool is_simulated_;
  std::vector<record::Channel> channels_;
  std::vector<std::vector<BiasMeter>> bias_;
  SteadyClock clock_;
  std::optional<std::pair<std::int64_t, Duration>> first_seen_;  ///< slot and time of arrival
  int shown_segment_ = -1;
  RunState shown_state_{};
};

/// Returns a second as a line of JSON: raw readings, null if missing; keys contain the physical unit. `events` must
/// belong to this second.
[[nodiscard]] std::string sample_json(const Sample& sample, std::span<const Event> events, const record::RunInfo& info);

}  // namespace gyrotherm::app
