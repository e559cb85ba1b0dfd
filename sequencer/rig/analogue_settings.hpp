// SPDX-License-Identifier: Apache-2.0
/// The [[analogue_input]] of a rig file: units of analogue inputs, and what they measure of which unit under test.
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

/// What one input measures.
struct AnalogueChannel {
  std::size_t input{};  ///< its place in the map
  std::string name;     ///< of the value
  std::size_t unit{};   ///< under test, its place in the rig
  std::size_t value{};  ///< its place among what analogue inputs measure of that unit
  double scale = 1;     ///< value = reading × scale + offset
  double offset = 0;
};

struct AnalogueSettings {
  std::string line;
  drivers::AnalogueMap map;  ///< on the link that suits the line
  std::vector<AnalogueChannel> channels;
};

/// "analogue input 1": the instrument of that place in the rig, in words.
[[nodiscard]] std::string title_of_analogue(std::size_t index);

/// Reads every [[analogue_input]]: `line`, `map` (a description's path relative to `rig_file`), `word_order`, `framing`
/// and `link` as for the chamber, and each [[analogue_input.channel]]: `input` (from 1), `name`, `unit` of measure,
/// `gyro` (the unit under test, which may be absent where the rig has one), `scale`, `offset`, and `temperature`, which
/// a value in °C may be. Each becomes one more value of its unit, behind those that are there. `known`: the maps'
/// texts, in order, where they are already known. Fails with bad_file for a map that cannot be used; mistakes of the
/// rig file are noted in it.
[[nodiscard]] Result<std::vector<AnalogueSettings>> read_analogue_inputs(const TomlTable& root,
                                                                         const std::string& rig_file,
                                                                         std::vector<UnitSettings>& units,
                                                                         const std::vector<std::string>& known);

/// The driver of one, on its wire. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<drivers::AnalogueInputs> make_analogue_inputs(
    const AnalogueSettings& settings, const std::string& place, std::unique_ptr<drivers::Registers> registers,
    std::unique_ptr<drivers::Pauses> pauses);

}  // namespace gyrotherm::rig
