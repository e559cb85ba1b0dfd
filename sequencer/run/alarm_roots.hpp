// SPDX-License-Identifier: Apache-2.0
/// Finds the common root of several alarms: a late host or a lost line. The root is raised as a separate alarm
/// (`host_late`, `line_lost`), and the alarm list suppresses its consequences. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/sample.hpp"
#include "sequencer/interlocks/interlocks.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::run {

inline constexpr const char* kHostLate = "host_late";
inline constexpr const char* kLineLost = "line_lost";

/// A line of the rig and the columns of a sample that are read through it.
struct RigLine {
  std::string subject;               ///< address; virtual: instrument
  std::vector<std::string> names{};  ///< subjects of alarms
  bool has_chamber{};
  std::vector<std::size_t> thermometers{};
  std::vector<std::size_t> units{};
  /// Returns true if the loss of the line can trip more than one interlock.
  [[nodiscard]] bool can_be_root() const { return !thermometers.empty() || units.size() + (has_chamber ? 1 : 0) > 1; }
};
/// Returns the lines of the rig. Instruments at one address share a line.
[[nodiscard]] std::vector<RigLine> rig_lines(const rig::RigFile& rig);

/// The state of both roots between seconds.
struct RootMemory {
  struct Line {
    bool raised{};
    /// Time since its last silent second.
    Duration answers{};
  };
  std::vector<Line> lines{};
  std::optional<Duration> since_late{};  ///< absent: no tick was late
  /// Time missed since the last minute without a late tick.
  Duration late{};
  bool host_raised{};
};

struct RootInputs {
  const Sample& sample;
  Duration missed{};  ///< time without ticks
  /// A longer time without ticks is a sleep of the machine.
  Duration longest_missed{};
  Duration clear_after{};
  /// Alarms of this second.
  const std::vector<interlocks::InterlockAlarm>& raised;
};

/// A root that was raised, or that returned to normal.
struct RootAlarm {
  std::string id;
  std::string subject{};
  std::string text;
};

struct RootResult {
  RootMemory memory;
  std::vector<RootAlarm> raised;
  std::vector<RootAlarm> cleared;
  /// The root of each raised alarm; empty: none.
  std::vector<std::string> roots;
};

/// Advances the roots by one second. A root is raised together with its first consequence; `host_late` is also raised
/// without one when the missed time reaches 10 s. `host_late` returns to normal after a minute without a late tick.
/// `line_lost` returns to normal once the line has answered for `clear_after` plus 5 s, later than its consequences.
[[nodiscard]] RootResult find_roots(const std::vector<RigLine>& lines, RootMemory memory, const RootInputs& inputs);

}  // namespace gyrotherm::run
