// SPDX-License-Identifier: Apache-2.0
/// The state that the interlocks keep from one second to the next: temperature trends, and the duration of each
/// interlock's cause. Plain values; any thread.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/sample.hpp"
#include "sequencer/interlocks/limits.hpp"
#include "sequencer/interlocks/liveness.hpp"

namespace gyrotherm::interlocks {

/// The change of one temperature over the last minute, and the time since its last change.
class Trend {
 public:
  /// Adds the value of one second; std::nullopt if it was not read.
  void add(std::optional<Celsius> value);
  /// Discards all samples of the trend. Call it after a time without samples.
  void forget();

  /// Returns the change over the last minute, or nothing if its first or last value is unknown.
  [[nodiscard]] std::optional<CelsiusPerMinute> rate() const;

  /// Compares the value with the other thermometers. Call it after add().
  void compare(std::optional<Celsius> others);
  /// Returns the number of latest samples in a row that are within a millikelvin of the first of them.
  [[nodiscard]] int unchanged_samples() const { return unchanged_; }
  /// Returns the change of the other thermometers since the value last changed.
  [[nodiscard]] Kelvins others_moved() const { return others_moved_; }

 private:
  static constexpr int kSeconds = 60;
  std::array<double, kSeconds + 1> ring_{};  ///< NaN: unknown
  int filled_ = 0, newest_ = -1;
  /// Value that the latest readings have in common; absent: the last reading differed from the one before it.
  std::optional<Celsius> unchanged_value_;
  int unchanged_ = 0;
  std::optional<Celsius> others_at_last_change_;
  Kelvins others_moved_{};
};

/// Counts the recent samples in which the cause was present, and the time they cover. A cause that is present in only
/// every other sample can thus still trip its interlock.
class RecentCauses {
 public:
  /// Adds a sample that covers `elapsed`. The window keeps at least the last `samples` samples and at least the last
  /// `time`. Do not call it for an unread sample.
  void add(bool found, Duration elapsed, int samples, Duration time) {
    window_.push_back({found, elapsed});
    count(window_.back(), 1);
    while (std::ssize(window_) > samples && whole_ - window_.front().elapsed >= time) {
      count(window_.front(), -1);
      window_.pop_front();
    }
  }
  void forget() { *this = {}; }

  [[nodiscard]] int samples() const { return samples_; }
  /// Returns the time covered by the samples with the cause.
  [[nodiscard]] Duration time() const { return time_; }

 private:
  struct Entry {
    bool found{};
    Duration elapsed{};
  };
  void count(const Entry& entry, int sign) {
    whole_ += entry.elapsed * sign;
    if (!entry.found) return;
    time_ += entry.elapsed * sign;
    samples_ += sign;
  }

  std::deque<Entry> window_;
  int samples_{};
  Duration time_{}, whole_{};
};

/// How much faster or slower than the median of all thermometers one of them changes, K/min, while the set point is
/// constant.
struct RateDifference {
  double now{};
  /// Least magnitude so far. It decays like the rate of a body that approaches the air, so a constant difference
  /// exceeds it in the end.
  double least{};
};

/// The air temperatures that the set points explain, from the first reading until the air has shown that it follows, or
/// for half an hour. A jump of the air sensor moves the range.
/// A controller that reads and shows set points in a wrong scale or unit moves the air out of this range at once.
struct ExplainedAir {
  /// First air temperature; absent: none was read together with a set point.
  std::optional<Celsius> first{};
  /// The range of the first air temperature and of all set points since.
  Celsius lowest{}, highest{};
  /// Total time for which the air has been watched.
  Duration watched{};
  /// Time for which the air has been near a set point that does not move and is far from `first`.
  Duration near_set_point{};
  /// The air has followed the set points to another temperature, or has been watched for long enough.
  bool has_followed = false;
};

struct InterlockMemory {
  /// The state of one subject of an interlock.
  struct Watch {
    /// Name of a channel, unit or instrument; may be empty.
    std::string subject{};
    /// Duration of the cause.
    Duration lasted{};
    /// Number of samples with the cause.
    int samples{};
    /// Time since the quantity that shows the cause was last read.
    Duration unseen{};
    /// Time since the cause was last found.
    Duration gone{};
    /// The alarm is raised, with this reaction; it is raised again if the reaction becomes more severe.
    bool raised{};
    Reaction reported{};
    RecentCauses recent{};  ///< the last samples
    /// Current reaction, or the last known one while the quantity is unread.
    Reaction reaction{};
    /// Column of the thermometer with the cause; absent: the cause is not a thermometer's.
    std::optional<std::size_t> column{};
    std::string text{};  ///< latest description of the cause
  };
  /// The watches of each interlock, one for each subject that has, or had, a cause.
  std::array<std::vector<Watch>, kInterlocks> watches{};
  /// Returns the watch of the most affected subject, or an empty watch if there is none.
  [[nodiscard]] Watch most_affected_watch(InterlockId id) const;
  /// Returns true if the cause was present in the last second, for any subject or for the given one. is_active() also
  /// requires a raised alarm.
  [[nodiscard]] bool is_cause_present(InterlockId id) const;
  [[nodiscard]] bool is_cause_present(InterlockId id, const std::string& subject) const;
  [[nodiscard]] bool is_active(InterlockId id) const;
  LivenessMemory liveness{};
  /// The chamber answered in the previous sample.
  bool chamber_answered = true;
  /// The chamber has reported its activity since it last failed to answer.
  bool activity_seen = true;
  Trend air;
  std::vector<Trend> thermometers;
  /// One per thermometer; absent: its rate is not known, the set point moved recently, or too few rates are known.
  std::vector<std::optional<RateDifference>> rate_differences{};
  /// Air temperature predicted from the set point.
  std::optional<Celsius> expected{};
  /// Largest recent distance of the predicted air from the set point. It decays with the time constant 3 × chamber_lag.
  Kelvins lag{};
  std::optional<Celsius> set_point{};
  ExplainedAir explained{};
  /// `explained` before the chamber was altered by another program, at its panel or by a restart; absent: it is not.
  std::optional<ExplainedAir> explained_before_alteration{};
  /// Set point of the altered chamber in the last second.
  std::optional<Celsius> altered_to{};
  /// Last known air temperature.
  std::optional<Celsius> last_air{};
  /// Time since `last_air` was read.
  Duration since_last_air{};
  /// Sum of the air's changes that were too fast to be real.
  Kelvins air_jump_sum{};
  std::optional<Duration> utc_minus_run{};
};

/// Fastest plausible change of the air. A faster change is a sensor fault. If 3 × air_fastest is greater, that limit
/// applies instead.
inline constexpr CelsiusPerMinute kFastestPlausibleAir{120};

/// The readings of the answering thermometers, sorted.
class Ranks {
 public:
  explicit Ranks(const Sample& sample);
  [[nodiscard]] std::optional<Celsius> median() const;
  /// Returns the median of the other thermometers. `own` is the reading to exclude, if it is known.
  [[nodiscard]] std::optional<Celsius> median_without(const std::optional<Celsius>& own) const;

 private:
  std::vector<double> sorted_;
};

/// Notes whether the chamber differs from its commanded state. Once it no longer does, or shows another foreign set
/// point, forgets the set points that this program has not sent: they only explain the present air temperature.
/// `before` is `memory.explained` before this second.
void note_alteration(bool is_altered, const ExplainedAir& before, const ChamberState& chamber, InterlockMemory& memory);

/// Adds a sample that covers `elapsed` to the trends. `is_after_pause` is true if the program paused before the sample.
void remember(const InterlockLimits& limits, const Sample& sample, Duration elapsed, bool is_after_pause,
              InterlockMemory& memory);

}  // namespace gyrotherm::interlocks
