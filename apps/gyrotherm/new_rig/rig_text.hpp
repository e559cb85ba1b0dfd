// SPDX-License-Identifier: Apache-2.0
/// Writes the commented text of a rig file, and of the description of a chamber that is not listed. Pure.
#pragma once

#include <string>
#include <vector>

#include "apps/gyrotherm/new_rig/rig_answers.hpp"

namespace gyrotherm::app {

/// Lines about an instrument, such as the result of its probe, by its title: "chamber", "thermometer 1", "gyro".
struct InstrumentNote {
  std::string title;
  std::string text;
};

/// Returns a file as an argument of --rig that is not taken for the name of a shipped rig.
[[nodiscard]] std::string rig_argument(const std::string& file);

/// Returns the text of the rig file. `notes` become comments of their instruments.
[[nodiscard]] std::string write_rig_text(const RigAnswers& answers, const std::vector<InstrumentNote>& notes);

/// Returns a register map or a text description with the values that only the chamber's manual contains marked as "FILL
/// IN". A reader of TOML lists them. Requires that the chamber is not listed.
[[nodiscard]] std::string write_chamber_text(const RigAnswers& answers);

}  // namespace gyrotherm::app
