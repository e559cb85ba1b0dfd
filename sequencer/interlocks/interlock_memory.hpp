// SPDX-License-Identifier: Apache-2.0
/// What the interlocks remember from second to second: how temperatures have moved, and how long each interlock has
/// stood. Values; any thread.
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

/// How one temperature has moved: over the last minute, and whether it moves at all.
class Trend {
 public:
  /// Adds one second's value, or that there was none.
  void add(std::optional<Celsius> value);
  /// Forgets everything, for time has passed unseen.
  void forget();

  /// The change over the last minute; nothing where one of its ends is not known.
  [[nodiscard]] std::optional<CelsiusPerMinute> rate() const;

  /// Compares with what the other thermometers show now, after add().
  void compare(std::optional<Celsius> others);
  /// For how many samples the value has not changed by a millikelvin.
  [[nodiscard]] int unchanged_samples() const { return unchanged_; }
  /// How far the others have moved since the value stopped changing.
  [[nodiscard]] Kelvins others_moved() const { return others_moved_; }

 private:
  static constexpr int kSeconds = 60;
  std::array<double, kSeconds + 1> ring_{};  ///< NaN: not known
  int filled_ = 0, newest_ = -1;
  std::optional<Celsius> still_;  ///< the value that does not change
  int unchanged_ = 0;
  std::optional<Celsius> others_then_;
  Kelvins others_moved_{};
};

/// Counts in how many of the last samples a cause was there, and for how long, so that a cause that comes and goes with
/// every second sample acts, too.
class RecentCauses {
 public:
  /// Adds a sample that was read and that covers `elapsed`. The window keeps at least the last `samples` samples and at
  /// least the last `time`.
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
  /// Returns the time covered by the samples in which the cause was there.
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

struct InterlockMemory {
  /// Holds what is remembered of one subject of an interlock.
  struct Watch {
    std::string subject{};                ///< channel, unit, instrument; may be empty
    Duration standing{};                  ///< how long its cause is there
    int samples{};                        ///< in how many samples it was there
    Duration unseen{};                    ///< since what shows it was last read
    Duration gone{};                      ///< how long it is not there, or not seen to be
    bool raised{};                        ///< its alarm
    RecentCauses recent{};                ///< its last samples
    Reaction reaction{};                  ///< what it asks for, of what cannot be seen as it was last seen
    std::optional<std::size_t> column{};  ///< which thermometer showed it
    std::string text{};                   ///< as last seen
  };
  /// The watches of each interlock, one for each subject that has, or had, a cause.
  std::array<std::vector<Watch>, kInterlocks> watches{};
  /// Returns the watch of the subject that is affected most; an empty watch if there is none.
  [[nodiscard]] Watch of(InterlockId id) const;
  /// Returns true if its cause is there in the last second, of any subject or of one; stands(): and acts besides.
  [[nodiscard]] bool is_seen(InterlockId id) const;
  [[nodiscard]] bool is_seen(InterlockId id, const std::string& subject) const;
  [[nodiscard]] bool stands(InterlockId id) const;
  LivenessMemory liveness{};
  bool chamber_answered = true;  ///< in the sample before
  bool activity_seen = true;     ///< the chamber has said what it does since it was last silent
  Trend air;
  std::vector<Trend> thermometers;
  std::optional<Celsius> expected{};  ///< the air, as it would follow the set point
  Kelvins lag{};                      ///< how far that is behind the set point; fades three times as slowly
  std::optional<Celsius> set_point{};
  std::optional<Celsius> air_seen{};  ///< the last that was known
  Duration air_unseen{};              ///< since then
  Kelvins air_jumped{};               ///< in all, over degrees that it did not pass through
  std::optional<Duration> utc_minus_run{};
};

/// Air that moves faster is no air; where a rig has faster air, three times as fast as that.
inline constexpr CelsiusPerMinute kNoAir{120};

/// The thermometers that answer, by size.
class Ranks {
 public:
  explicit Ranks(const Sample& sample);
  [[nodiscard]] std::optional<Celsius> median() const;
  /// The median of the others; `own` is one of the thermometers if it is known.
  [[nodiscard]] std::optional<Celsius> median_without(const std::optional<Celsius>& own) const;

 private:
  std::vector<double> sorted_;
};

/// Takes a sample that covers `elapsed` into the trends; `after_a_pause`: the program stood still before it.
void remember(const InterlockLimits& limits, const Sample& sample, Duration elapsed, bool after_a_pause,
              InterlockMemory& memory);

}  // namespace gyrotherm::interlocks
