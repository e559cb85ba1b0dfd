// SPDX-License-Identifier: Apache-2.0
/// Analogue inputs of a rig file, [[analogue_input]]: the instruments, and the quantities of the units under test that
/// they measure.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "drivers/analogue/modbus_analogue_input.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/wires.hpp"
#include "sequencer/rig/gyro_settings.hpp"

namespace gyrotherm::rig {

/// One input and the value that it measures.
struct AnalogueChannel {
  /// Index of the input in the map.
  std::size_t input{};
  /// Name of the value.
  std::string name;
  /// Unit under test: index in the rig.
  std::size_t unit{};
  /// Index among the values of that unit that analogue inputs measure.
  std::size_t value{};
  /// Value = reading × scale + offset.
  double scale = 1;
  double offset = 0;
};

struct AnalogueSettings {
  std::string line;
  /// The map, with the link for the line selected.
  drivers::AnalogueMap map;
  std::vector<AnalogueChannel> channels;
};

/// Returns the instrument's title, such as "analogue input 1".
[[nodiscard]] std::string analogue_title(std::size_t index);

/// Reads every [[analogue_input]]: `line`, `map` (a description's path relative to `rig_file`), `word_order`, `framing`
/// and `link` as for the chamber, and each [[analogue_input.channel]]: `input` (from 1), `name`, `unit` of measure,
/// `gyro` (the unit under test; optional if the rig has only one), `scale`, `offset`, and `temperature` for a value in
/// °C. Appends each channel to the values of its unit. `known` contains the texts of the maps, in order, if they are
/// known already. Fails with bad_file if a map cannot be used. Records errors of the rig file in its tables.
[[nodiscard]] Result<std::vector<AnalogueSettings>> read_analogue_inputs(const TomlTable& root,
                                                                         const std::string& rig_file,
                                                                         std::vector<UnitSettings>& units,
                                                                         const std::vector<std::string>& known);

/// Makes the driver of one instrument on its wire. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<drivers::AnalogueInputs> make_analogue_inputs(
    const AnalogueSettings& settings, const std::string& place, std::unique_ptr<drivers::Registers> registers,
    std::unique_ptr<drivers::Pauses> pauses);

}  // namespace gyrotherm::rig
