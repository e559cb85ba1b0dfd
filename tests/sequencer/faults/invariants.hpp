// SPDX-License-Identifier: Apache-2.0
/// What each second of a simulated run must obey, whatever goes wrong: judged from outside, by what the chamber was
/// really sent and what the record was really given.
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

/// "I2 at second 133: …"
using Violations = std::vector<std::string>;

/// How severe: execute 0, suspended 1, held 2, aborting and aborted 3, stopped and complete 4.
[[nodiscard]] int severity(RunState state);

/// What a row of the record says of the profile.
struct RowBrief {
  std::int64_t slot{};
  int segment{};
  RunState state{};
  bool in_band{};          ///< of the segment's soak
  std::uint64_t values{};  ///< hash of all that it says
  bool operator==(const RowBrief&) const = default;
};

class Invariants {
 public:
  /// All of them outlive it.
  Invariants(const profile::Profile& profile, const rig::RigFile& file, Plant& plant, const FaultInjector& injector);

  /// A program begins, at the first second or by taking up a record whose last row or gap is `last_recorded`.
  void life_begins(std::int64_t last_recorded);
  /// The world stands as the tick will find it.
  void before_tick() { in_force_ = plant_.laboratory().set_point(); }
  /// `recording` has what this tick brought.
  void after_tick(std::int64_t second, const RecordingStore& recording, const Operators& operators);
  /// Seconds that passed without a program, or without a tick.
  void no_tick() {
    quiet_ticks_ = {};
    untroubled_ticks_.clear();
    begin_liveness_anew();
  }
  /// A record was taken up, and the profile goes on there.
  void judge_resumption(std::int64_t second, const ProfilePosition& at);
  /// What the closed record holds; `left_unwritten`: its last rows waited for the disk in vain.
  void judge_record(std::int64_t second, const record::Record& record, std::int64_t acknowledged, bool left_unwritten);
  /// The profile's end was reported.
  void completed(std::int64_t second);
  /// The run has ended and counts the chamber as safe.
  void left_as_safe(std::int64_t second);
  /// Whether a injected fault of the kinds from `first` to `last` stands now.
  [[nodiscard]] bool stands(InjectedFaultKind first, InjectedFaultKind last) const;
  void broken(const char* invariant, std::int64_t second, const std::string& what);

  [[nodiscard]] const Violations& violations() const { return violations_; }
  [[nodiscard]] const std::vector<RowBrief>& rows() const { return rows_; }
  [[nodiscard]] std::int64_t gap_seconds() const;
  [[nodiscard]] const std::array<std::int64_t, 7>& seconds_in_state() const { return seconds_in_state_; }

 private:
  /// How many ticks in a row something has been so.
  struct Ticks {
    std::int64_t link_bad{}, link_good{}, thermometers_bad{}, door{}, limiter{}, off{}, other_set_point{}, beyond{},
        aborting{}, lossy{}, disk_dead{};
  };
  /// A thermometer that gives no reading.
  struct LostChannel {
    std::int64_t ticks{};
    bool told{};
  };

  void begin_liveness_anew() { ticks_of_life_ = 0, identical_.clear(), without_counts_.clear(), beyond_.clear(); }
  void judge_set_points(std::int64_t second, RunState state);
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

  const profile::Profile& profile_;
  const rig::RigFile& file_;
  Plant& plant_;
  const FaultInjector& injector_;
  Celsius lowest_, highest_;
  Violations violations_;
  Celsius in_force_;                           ///< the chamber's set point before the tick
  std::optional<Celsius> sent_, sent_before_;  ///< last, and before the tick
  int tries_ = 0;                              ///< of the same set point again
  bool is_kept_away_ = false;  ///< the air, by a chamber that was broken, since it was last where it should
  std::optional<RunState> last_state_;
  Duration last_time_{Duration::min()};
  std::vector<RowBrief> rows_;
  std::vector<RecordingStore::GapSeen> gaps_;
  std::deque<double> from_safe_k_;  ///< distance of the air from the safe set point, last minute
  std::int64_t last_slot_ = -1;     ///< that has a row or a gap
  Ticks quiet_ticks_;
  bool storage_told_ = false;
  std::vector<std::size_t> places_;  ///< of each channel, in the laboratory
  std::vector<LostChannel> lost_channels_;
  std::vector<std::int64_t> untroubled_ticks_;  ///< of each unit's line
  std::array<std::int64_t, 7> seconds_in_state_{};

  /// Readings of one instrument that are stored as good and identical to those before.
  struct Identical {
    std::vector<double> last;
    std::int64_t rows{}, longest{};
  };
  std::int64_t ticks_of_life_ = 0;            ///< without a break
  std::vector<Identical> identical_;          ///< by thermometer instrument
  std::vector<std::int64_t> without_counts_;  ///< rows, by unit
  std::vector<std::vector<bool>> beyond_;     ///< last readings beyond a limit: of each thermometer, then the air
};

}  // namespace gyrotherm::faults
