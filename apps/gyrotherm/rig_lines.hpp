// SPDX-License-Identifier: Apache-2.0
/// Instruments of a rig file and the lines that they are connected to, as `check` and `doctor` look at them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/line/line_address.hpp"
#include "drivers/line/process_stream.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

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

}  // namespace gyrotherm::app
