// SPDX-License-Identifier: Apache-2.0
/// Modbus units with analogue inputs: the register map, a TOML file under profiles/analogue-inputs that the virtual
/// unit uses from the other end of the wire, and the driver of any unit that such a map describes.
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
  std::string item;  ///< the register that holds it
  std::string unit;  ///< of measure, of the register's value: "mA", "V", "°C"
  /// The registers whose codes "normal" say that the value counts: what it is doing, how it is set.
  std::vector<std::string> statuses;
  bool operator==(const AnalogueInput&) const = default;
};

/// The register map of a unit: its registers, as for a chamber, and which of them are its inputs. A value.
struct AnalogueMap {
  RegisterMap registers;
  std::vector<AnalogueInput> inputs;  ///< at least one, the first is input 1
};

/// The code of a status register that says that an input counts.
inline constexpr const char* kNormalStatus = "normal";

/// Reads schema gyrotherm-analogue-inputs/1: name, vendor, source, [link], [[register]] and [identity] are those of a
/// chamber's map (docs/chamber-maps.md); each [[input]] names its `register`, which is a number that can be read, the
/// `unit` of measure, and may name one or more `status` registers, which have a code "normal". Where the registers were
/// made by `count`, so are the inputs: register "current" is "current_1", "current_2", … Fails with bad_file, every
/// mistake with its place. `word_order`: the user's override for a unit that was set up differently.
[[nodiscard]] Result<AnalogueMap> parse_analogue_map(std::string_view text, const std::string& file,
                                                     std::optional<WordOrder> word_order = {});

/// "8 inputs: from the manual", and what is not sure of them: a line for people.
[[nodiscard]] std::string confidence_in_words(const AnalogueMap& map);

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
