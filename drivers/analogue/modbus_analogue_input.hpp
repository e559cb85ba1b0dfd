// SPDX-License-Identifier: Apache-2.0
/// Any Modbus unit with analogue inputs that a register map describes.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "drivers/analogue/analogue_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// `registers` are those of the map's link in use. `wanted` are the inputs that read() gives, in this order, by their
/// places in the map; at least one. Registers that follow each other are read by one exchange, as many as the link
/// allows, and where the map says `holes`, with what lies between them; what holds no wanted input is not read.
///
/// An input is out_of_range if its register holds a sentinel or what cannot be, if a status register of its does not
/// say "normal", or if the unit has no value of it now; a line that is silent for one exchange is not asked for the
/// next. `place` names the unit in its faults: "analogue input 1".
[[nodiscard]] std::unique_ptr<AnalogueInputs> make_modbus_analogue_inputs(
    AnalogueMap map, std::vector<std::size_t> wanted, std::string place, std::unique_ptr<Registers> registers,
    std::unique_ptr<Pauses> pauses = real_pauses());

}  // namespace gyrotherm::drivers
