// SPDX-License-Identifier: Apache-2.0
/// The invariants of each second of a simulated run, under any faults. They are checked from outside the program, on
/// the set points that the chamber received and the rows that were written to the record.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "sequencer/profile/profile.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "tests/sequencer/faults/fault_injector.hpp"
#include "tests/sequencer/faults/operators.hpp"
#include "tests/sequencer/faults/plant.hpp"
#include "tests/sequencer/faults/recording_store.hpp"

namespace gyrotherm::faults {

/// Texts such as "I2 at second 133: …".
using Violations = std::vector<std::string>;

/// Returns the severity of a state: execute 0, suspended 1, held 2, aborting and aborted 3, stopped and complete 4.
[[nodiscard]] int severity(RunState state);

/// A row of the record, reduced to the profile's data.
struct RowBrief {
  std::int64_t slot{};
  int segment{};
  RunState state{};
  /// Inside the segment's soak band.
  bool in_band{};
  /// Hash of all values.
  std::uint64_t values{};
  bool operator==(const RowBrief&) const = default;
};

class Invariants {
 public:
  /// All arguments must outlive this object.
  Invariants(const profile::Profile& profile, const rig::RigFile& file, Plant& plant, const FaultInjector& injector);

  /// Begins a life of the program, with a new record or with one whose last row or gap is in slot `last_recorded`.
  void begin_life(std::int64_t last_recorded);
  /// Records the world's state before the tick.
  void before_tick() { in_force_ = plant_.laboratory().set_point(); }
  /// Judges one tick. `recording` contains its rows and events.
  void after_tick(std::int64_t second, const RecordingStore& recording, const Operators& operators);
  /// Takes the profile of a run that ends by itself after a decision or a resume.
  void take_profile(const profile::Profile& profile) { profile_ = profile; }
  /// Resets the counts of consecutive ticks after seconds without a program or without a tick.
  void skip_tick() {
    quiet_ticks_ = {};
    untroubled_ticks_.clear();
    restart_liveness();
  }
  /// Judges the position at which a resumed run continues.
  void judge_resume(std::int64_t second, const ProfilePosition& at);
  /// Judges the closed record. `left_unwritten` is true if the disk did not accept its last rows.
  void judge_record(std::int64_t second, const record::Record& record, std::int64_t acknowledged, bool left_unwritten);
  /// Judges a run that reported the profile's end.
  void completed(std::int64_t second);
  /// Judges a run that has ended and reported the chamber as safe.
  void check_end_of_safe_run(std::int64_t second);
  /// Returns true if a fault of the kinds from `first` to `last` is active.
  [[nodiscard]] bool is_active(InjectedFaultKind first, InjectedFaultKind last) const;
  void report_violation(const char* invariant, std::int64_t second, const std::string& what);

  [[nodiscard]] const profile::Profile& profile() const { return profile_; }
  [[nodiscard]] const Violations& violations() const { return violations_; }
  [[nodiscard]] const std::vector<RowBrief>& rows() const { return rows_; }
  [[nodiscard]] std::int64_t gap_seconds() const;
  [[nodiscard]] const std::array<std::int64_t, 7>& seconds_in_state() const { return seconds_in_state_; }

 private:
  /// Numbers of consecutive ticks for which a condition has been true.
  struct Ticks {
    std::int64_t link_bad{}, link_good{}, thermometers_bad{}, door{}, limiter{}, off{}, other_set_point{}, beyond{},
        aborting{}, lossy{}, disk_dead{};
  };
  /// A thermometer without a reading.
  struct LostChannel {
    std::int64_t ticks{};
    bool reported{};
  };

  void restart_liveness() { ticks_of_life_ = 0, identical_.clear(), without_counts_.clear(), beyond_.clear(); }
  void judge_set_points(std::int64_t second, const Sample& sample);
  void judge_rows(std::int64_t second, const RecordingStore& recording);
  void judge_values(std::int64_t second, const Sample& sample);
  void judge_identities(std::int64_t second, const Sample& sample);
  void judge_units(std::int64_t second, const Sample& sample, const Operators& operators);
  [[nodiscard]] bool is_troubled(std::size_t line) const;
  void judge_state(std::int64_t second, const Sample& sample);
  void judge_machine(std::int64_t second, const RecordingStore& recording, RunState state);
  void judge_alarms(std::int64_t second, const RecordingStore& recording);
  void judge_channels(std::int64_t second, const RecordingStore& recording, const Sample& sample,
                      const Operators& operators);
  void judge_segments(std::int64_t second, const Sample& sample);
  void judge_liveness(std::int64_t second, const Sample& sample);
  void judge_limits(std::int64_t second, const Sample& sample);
  void judge_segment_end(std::int64_t second, int segment);
  void count_ticks(const Sample& sample);
  void judge_reactions(std::int64_t second, const Sample& sample);

  profile::Profile profile_;
  const rig::RigFile& file_;
  Plant& plant_;
  const FaultInjector& injector_;
  Celsius lowest_, highest_;
  Violations violations_;
  /// The chamber's set point before the tick.
  Celsius in_force_;
  /// Last set point that was sent, after and before the tick.
  std::optional<Celsius> sent_, sent_before_;
  /// Number of attempts to send the same set point.
  int tries_ = 0;
  /// A broken chamber keeps the air away from its expected value.
  bool is_kept_away_ = false;
  std::optional<RunState> last_state_;
  Duration last_time_{Duration::min()};
  std::vector<RowBrief> rows_;
  std::vector<RecordingStore::GapSeen> gaps_;
  std::deque<double> from_safe_k_;  ///< values of the last minute
  /// Last slot with a row or a gap.
  std::int64_t last_slot_ = -1;
  Ticks quiet_ticks_;
  bool storage_alarm_ = false;
  /// Index of each channel in the laboratory.
  std::vector<std::size_t> places_;
  std::vector<LostChannel> lost_channels_;
  /// One element per gyro line.
  std::vector<std::int64_t> untroubled_ticks_;
  std::array<std::int64_t, 7> seconds_in_state_{};

  /// Consecutive rows in which the stored good readings of one instrument are equal.
  struct Identical {
    std::vector<double> last;
    std::int64_t rows{}, longest{};
  };
  /// Consecutive ticks without an interruption.
  std::int64_t ticks_of_life_ = 0;
  std::vector<Identical> identical_;          ///< per thermometer instrument
  std::vector<std::int64_t> without_counts_;  ///< rows, by unit
  /// Flags of the last readings outside a limit: one list per thermometer, then the air.
  std::vector<std::vector<bool>> beyond_;
};

}  // namespace gyrotherm::faults
