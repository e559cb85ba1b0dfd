// SPDX-License-Identifier: Apache-2.0
/// The set points that a chamber is sent: never faster than the ramp limit, never beyond the limits, one at a time,
/// each read back before the next.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/io/instrument_io.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "sequencer/profile/profile.hpp"

namespace gyrotherm::run {

/// One step from `from` towards `goal` that takes `time`.
[[nodiscard]] Celsius step_towards(Celsius from, Celsius goal, const profile::ChamberLimits& limits, Duration time);
[[nodiscard]] Celsius within(Celsius target, const profile::ChamberLimits& limits);

/// Counts the set points that a run of `profile` sends, none of them refused: the first, then one for each `every` (a
/// second at least) in which the set point moves.
[[nodiscard]] std::int64_t count_set_points(const profile::Profile& profile, const profile::ChamberLimits& limits,
                                            Duration every);

class SetPointPath {
 public:
  /// `sent`: what the chamber has taken at `at`, the time of the run.
  SetPointPath(const profile::ChamberLimits& limits, Kelvins tolerance, Duration every, Celsius sent, Duration at);

  /// Goes on towards `goal` as far as the time allows; sends nothing if the chamber is there, or was sent one too
  /// recently, but for the beginning of a path. Fails as InstrumentIo::send_set_point() does: then what the chamber has
  /// is not known until it is seen.
  [[nodiscard]] Result<void> advance(io::InstrumentIo& io, Celsius goal, Duration at);
  /// The next set point is `here`, where the air is, and the path goes on from there.
  void begin_at(Celsius here);
  /// What the chamber shows is taken for what it was sent.
  void adopt(Celsius set_point);

  /// What the chamber should show: the last it took or, if it did not take the one after, what is nearer to `shown`.
  [[nodiscard]] Celsius expected(Celsius shown) const;
  /// The chamber has taken `goal`.
  [[nodiscard]] bool is_at(Celsius goal) const { return known_ && !begins_ && held_ == goal; }
  [[nodiscard]] Kelvins tolerance() const { return tolerance_; }
  [[nodiscard]] int refusals() const { return refusals_; }  ///< in a row
  /// The chamber has just not taken one, and is sent another as soon as it may be.
  [[nodiscard]] bool sends_again(Duration at) const {
    return refusals_ > 0 && at - tried_ < std::max(every_, Duration(kSecond));
  }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }
  [[nodiscard]] std::int64_t missed() const { return missed_; }  ///< set points in all that it did not take

 private:
  profile::ChamberLimits limits_;
  Kelvins tolerance_;
  Duration every_;
  Celsius held_;                      ///< the last that the chamber took
  bool known_ = true;                 ///< that it holds that one
  std::optional<Celsius> attempted_;  ///< that it did not take, or may have
  Celsius base_;                      ///< where the path is
  bool begins_ = false;               ///< the next set point is the path's beginning
  Duration at_;                       ///< when the chamber took the last one
  Duration tried_;                    ///< when it was last sent one
  int refusals_ = 0;
  std::string refusal_;
  std::int64_t missed_ = 0;
};

}  // namespace gyrotherm::run
