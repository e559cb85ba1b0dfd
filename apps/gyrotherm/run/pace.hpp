// SPDX-License-Identifier: Apache-2.0
/// Pace of virtual time: the seconds of a virtual rig that pass in one second of wall time.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <optional>
#include <string>

#include "core/result.hpp"

namespace gyrotherm::app {

/// Returns the seconds of virtual time per second of wall time, or 0 for as fast as possible. `text` is "real", "max"
/// or "xN". Fails with usage for any other text.
[[nodiscard]] Result<double> parse_pace(const std::string& text);

/// Returns the pace of a run, from the value of --pace; an empty text is "max". Fails with usage like parse_pace(), and
/// on a real rig, which runs in real time, for any value.
[[nodiscard]] Result<double> pace_of_run(const std::string& text, bool is_virtual);

/// Adds the option --pace, whose value is "real", "max" or "xN".
CLI::Option* add_pace_option(CLI::App& command, std::string& pace, const std::string& help);

/// Determines when each second of a virtual run is due. A run that an operator has paused takes at least one second of
/// wall time for each second of the rig, so that a pause lasts as long as for a real rig.
class Pacer {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// `pace` is 0 for as fast as possible.
  explicit Pacer(double pace) : pace_(pace) {}

  /// Returns the time at which the next second is due; nothing if it is due immediately. Call it once a second. A
  /// machine that was too slow does not catch up.
  [[nodiscard]] std::optional<TimePoint> next_second(TimePoint now, bool is_paused);

 private:
  double pace_;
  std::optional<TimePoint> due_;
};

}  // namespace gyrotherm::app
