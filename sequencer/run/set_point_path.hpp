// SPDX-License-Identifier: Apache-2.0
/// The sequence of set points for a chamber. It stays within the chamber's limits and ramp rate, and sends a set point
/// only after the previous one was read back.
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

/// Returns the set point after one step of `time` from `from` towards `goal`.
[[nodiscard]] Celsius step_towards(Celsius from, Celsius goal, const profile::ChamberLimits& limits, Duration time);
[[nodiscard]] Celsius clamp_to_limits(Celsius target, const profile::ChamberLimits& limits);

/// Counts the set points that a run of `profile` sends if none is refused: the first, then one for each `every` (at
/// least a second) in which the set point moves.
[[nodiscard]] std::int64_t count_set_points(const profile::Profile& profile, const profile::ChamberLimits& limits,
                                            Duration every);

class SetPointPath {
 public:
  /// `sent` is the set point that the chamber accepted at the run time `at`.
  SetPointPath(const profile::ChamberLimits& limits, Kelvins tolerance, Duration every, Celsius sent, Duration at);

  /// Moves towards `goal` as far as the time allows. Sends nothing if the chamber is there, or if the last set point is
  /// too recent, except at the beginning of a path. Fails as InstrumentIo::send_set_point() does; then the chamber's
  /// set point is unknown until it is read.
  [[nodiscard]] Result<void> advance(io::InstrumentIo& io, Celsius goal, Duration at);
  /// Begins a new path: the next set point is `here`, the air's temperature.
  void begin_at(Celsius here);
  /// Uses the set point that the chamber shows as the last accepted one.
  void accept_as_sent(Celsius set_point);

  /// Returns the set point that the chamber should show: the last accepted one. If the next one was refused, returns
  /// whichever of the two is nearer to `shown`.
  [[nodiscard]] Celsius expected(Celsius shown) const;
  /// Returns true if the chamber has accepted `goal`.
  [[nodiscard]] bool is_at(Celsius goal) const { return known_ && !begins_ && held_ == goal; }
  [[nodiscard]] Kelvins tolerance() const { return tolerance_; }
  [[nodiscard]] int refusals() const { return refusals_; }  ///< in a row
  /// Returns true if a set point was refused just now and will be sent again as soon as permitted.
  [[nodiscard]] bool sends_again(Duration at) const {
    return refusals_ > 0 && at - tried_ < std::max(every_, Duration(kSecond));
  }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }
  [[nodiscard]] std::int64_t missed() const { return missed_; }  ///< refused set points in all
  /// Set points in all whose confirmation did not arrive in time. The chamber may have them.
  [[nodiscard]] std::int64_t unconfirmed() const { return unconfirmed_; }

 private:
  profile::ChamberLimits limits_;
  Kelvins tolerance_;
  Duration every_;
  /// Last accepted set point.
  Celsius held_;
  /// The chamber's set point is known, and is `held_`.
  bool known_ = true;
  /// Refused set point, which the chamber may nevertheless have accepted.
  std::optional<Celsius> attempted_;
  /// Current position of the path.
  Celsius base_;
  /// The next set point is the first one of a path.
  bool begins_ = false;
  /// Time of the last accepted set point.
  Duration at_;
  /// Time of the last attempt.
  Duration tried_;
  int refusals_ = 0;
  std::string refusal_;
  std::int64_t missed_ = 0, unconfirmed_ = 0;
};

}  // namespace gyrotherm::run
