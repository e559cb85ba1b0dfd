// SPDX-License-Identifier: Apache-2.0
/// Modbus units with analogue inputs: the register map, a TOML file under profiles/analogue-inputs, which the virtual
/// unit also uses, and the driver.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// One input of the unit.
struct AnalogueInput {
  std::string item;  ///< register of the value
  /// Unit of measure of the register's value: "mA", "V", "°C".
  std::string unit;
  /// Registers with operating states or settings of the input. The value is valid if each has the code "normal".
  std::vector<std::string> statuses;
  bool operator==(const AnalogueInput&) const = default;
};

/// The register map of a unit: its registers, as for a chamber, and its inputs.
struct AnalogueMap {
  RegisterMap registers;
  std::vector<AnalogueInput> inputs;  ///< at least one
};

/// Code of a status register for a valid input.
inline constexpr const char* kNormalStatus = "normal";

/// Parses schema gyrotherm-analogue-inputs/1. The keys name, vendor, source, [link], [[register]] and [identity] have
/// the same meaning as in a chamber's map (docs/chamber-maps.md). Each [[input]] names its `register`, a readable
/// number, and the `unit` of measure. It may name `status` registers, which must have a code "normal". If the register
/// has a `count`, there is one input for each of "current_1", "current_2", … Fails with bad_file and lists every error
/// with its position. `word_order` overrides the map's order, for a unit with a different setting.
[[nodiscard]] Result<AnalogueMap> parse_analogue_map(std::string_view text, const std::string& file,
                                                     std::optional<WordOrder> word_order = {});

/// Returns a line of text with the number of inputs, the least confidence of their registers, and the notes: "8 inputs:
/// manual; …".
[[nodiscard]] std::string describe_confidence(const AnalogueMap& map);

/// Returns the driver. `registers` must belong to the map's selected link. `wanted` contains the indices in the map of
/// at least one input; read() returns these inputs in this order. Adjacent registers are read by one exchange, up to
/// the limit of the link; if the map has `holes`, registers with gaps between them as well. Spans without a requested
/// input are not read.
///
/// An input is out_of_range if its register has a sentinel or an impossible value, if one of its status registers is
/// not "normal", or if the unit has no value at present. After an exchange without an answer, the remaining exchanges
/// of the reading are skipped. `place` names the unit in its faults: "analogue input 1".
[[nodiscard]] std::unique_ptr<AnalogueInputs> make_modbus_analogue_inputs(
    AnalogueMap map, std::vector<std::size_t> wanted, std::string place, std::unique_ptr<Registers> registers,
    std::unique_ptr<Pauses> pauses = make_real_pauses());

}  // namespace gyrotherm::drivers
