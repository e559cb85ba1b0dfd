// SPDX-License-Identifier: Apache-2.0
/// Contacts the instruments of a rig file that is about to be written. Only questions are sent: no register is written,
/// no scanner is configured, and no start command is sent to a gyro.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/chamber/register_map.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

struct Probe {
  std::string title;  ///< "chamber", "thermometer 1", "gyro"
  bool answers{};
  /// Description of the answer, or the reason why there is none, in one line.
  std::string text;
};

/// Returns the word order that alone gives plausible values of a chamber whose map has another one; nothing if the
/// order of the map is plausible, if several others are, or if the chamber does not answer.
[[nodiscard]] std::optional<drivers::WordOrder> find_other_word_order(const rig::RigFile& rig);

/// Queries each instrument of a real rig: its identity and its readings. A scanner that must be configured before it
/// measures is asked for its identity only. If another program drives the chamber, nothing is contacted.
[[nodiscard]] std::vector<Probe> probe_instruments(const rig::RigFile& rig);

}  // namespace gyrotherm::app
