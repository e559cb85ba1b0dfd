// SPDX-License-Identifier: Apache-2.0
/// Finds the root of alarms that follow from one event: a host that is late, or a line that is lost. The root is an
/// alarm of its own (`host_late`, `line_lost`), and the list of alarms suppresses its consequences under it. Pure; any
/// thread.
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
  /// Returns true if the lost line shows in more than one interlock.
  [[nodiscard]] bool can_be_root() const { return !thermometers.empty() || units.size() + (has_chamber ? 1 : 0) > 1; }
};
/// Returns the lines of the rig. Instruments at one address share a line.
[[nodiscard]] std::vector<RigLine> lines_of(const rig::RigFile& rig);

/// The state of both roots between seconds.
struct RootMemory {
  struct Line {
    bool raised{};
    Duration answers{};  ///< since its last silent second
  };
  std::vector<Line> lines{};
  std::optional<Duration> since_late{};  ///< nothing: never late
  Duration late{};                       ///< missed since the last good minute
  bool host_raised{};
};

struct RootInputs {
  const Sample& sample;
  Duration missed{};          ///< time without ticks
  Duration longest_missed{};  ///< longer: the machine slept
  Duration clear_after{};
  const std::vector<interlocks::InterlockAlarm>& raised;  ///< alarms of this second
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
  std::vector<std::string> roots;  ///< per raised alarm; empty: none
};

/// Steps one second. A root is raised with its first consequence. A host that is late for 10 s within minutes is raised
/// without one. `host_late` returns after a minute in time, `line_lost` 5 s after `clear_after`, so that its
/// consequences have returned by then.
[[nodiscard]] RootResult find_roots(const std::vector<RigLine>& lines, RootMemory memory, const RootInputs& inputs);

}  // namespace gyrotherm::run
