// SPDX-License-Identifier: Apache-2.0
/// The second that `run` and `resume` show of a run under way: as a few lines, redrawn in place on a terminal, a plain
/// one now and then elsewhere, none with --quiet; and as JSON.
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

/// Measures the bias on one axis: the rate less what of the Earth's rate is known.
class BiasMeter {
 public:
  /// The axis numbered `index` of its unit.
  explicit BiasMeter(const record::AxisInfo& axis, std::size_t index = 0) : meter_(axis, index) {}
  void see(const Reading<GyroCount>& reading) { meter_.see(reading); }
  [[nodiscard]] std::optional<DegreesPerHour> last_second() const { return bias_of(meter_.last_second()); }
  /// Takes the seconds among the last 100 that had a reading; nothing if there is none.
  [[nodiscard]] std::optional<DegreesPerHour> mean() const { return bias_of(meter_.mean()); }

 private:
  [[nodiscard]] std::optional<DegreesPerHour> bias_of(std::optional<DegreesPerHour> rate) const;

  record::RateMeter meter_;
};

class Display {
 public:
  /// All of them outlive it.
  Display(Console& console, const profile::Profile& profile, const rig::RigFile& rig);

  /// Each second.
  void see(const Sample& sample);
  /// Now and then: after each second or each batch of them.
  void show(const Sample& sample, const RunStanding& standing, std::span<const record::Alarm> alarms);

  /// The lines for a terminal, the newest second in them. `alarms`: the rows of the list, newest first.
  [[nodiscard]] std::vector<std::string> lines(const Sample& sample, const RunStanding& standing,
                                               std::span<const record::Alarm> alarms = {}) const;
  /// How long the end is away, by the clock on the wall: of a dry run by how fast it has gone so far; nothing while
  /// that is not known, or where the run does not go on.
  [[nodiscard]] std::optional<Duration> time_left(const Sample& sample, const RunStanding& standing) const;

 private:
  [[nodiscard]] std::string unit_line(std::size_t unit) const;
  [[nodiscard]] std::string headline(const Sample& sample, const RunStanding& standing) const;
  [[nodiscard]] std::string clock_line(const Sample& sample, const RunStanding& standing) const;
  [[nodiscard]] std::vector<std::string> temperature_lines(const Sample& sample) const;

  Console& console_;
  const profile::Profile& profile_;
  const rig::RigFile& rig_;
  std::vector<record::Channel> channels_;
  std::vector<std::vector<BiasMeter>> bias_;  ///< of each unit's axes
  SteadyClock clock_;
  std::optional<std::pair<std::int64_t, Duration>> first_seen_;  ///< a slot, and when it was seen
  int shown_segment_ = -1;
  RunState shown_state_{};
};

/// Returns a second as a line of JSON: raw readings as they came, null where there is none; keys say the unit.
/// `events`: those of this second.
[[nodiscard]] std::string sample_json(const Sample& sample, std::span<const Event> events, const record::RunInfo& info);

}  // namespace gyrotherm::app
