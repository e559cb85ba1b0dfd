// SPDX-License-Identifier: Apache-2.0
/// The facts of a rig that a person should know before anything moves: the lines of its instruments, its calibrations,
/// and the go/no-go block before a run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/gyrotherm/machine_checks.hpp"
#include "core/quantity.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/process_stream.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// An instrument of a rig file and the line that it is connected to.
struct Connected {
  std::string title;
  std::string line;
  std::uint16_t usual_port = drivers::LineDefaults{}.port;
  /// The program that reads the instrument. Without words: none.
  drivers::ProgramCommand program{};
};

/// Lists the chamber, the thermometers, the gyros and the analogue inputs, in this order.
[[nodiscard]] std::vector<Connected> instrument_lines(const rig::RigFile& rig);

/// Returns why the name of a serial line's device may be another adapter's tomorrow, and the name to be used; empty if
/// it is a stable one.
[[nodiscard]] std::string unstable_name(const std::string& line);

/// Returns a sentence for each calibration that is overdue on the day on which the rig would run.
[[nodiscard]] std::vector<std::string> overdue(const rig::RigFile& rig);

/// Returns where the zero of the bias comes from. A warning if the Earth rate of an axis is unknown: the mean of the
/// first hold is then its zero.
[[nodiscard]] Finding check_bias_zero(const rig::RigFile& rig);

/// Returns the zero of the bias, the calibrations on that day, the chamber's limiter, the disk of the record and the
/// guard. A virtual rig has neither limiter nor guard.
[[nodiscard]] std::vector<Finding> check_readiness(const rig::RigFile& rig, const std::string& record, Duration utc);

/// Prints the findings and the verdict: GO, GO WITH n WARNINGS or NO-GO. Of a virtual rig it prints warnings alone.
void say_readiness(Console& console, const rig::RigFile& rig, const std::vector<Finding>& findings);

}  // namespace gyrotherm::app
