// SPDX-License-Identifier: Apache-2.0
/// The register map of a Modbus unit with analogue inputs: a TOML file under profiles/analogue-inputs, used by the
/// driver and, from the other end of the wire, by the virtual unit. Values; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::drivers {

/// One input of the unit.
struct AnalogueInput {
  std::string item;  ///< the register that holds it
  std::string unit;  ///< of measure, of the register's value: "mA", "V", "°C"
  /// The registers whose codes "normal" say that the value counts: what it is doing, how it is set.
  std::vector<std::string> statuses;
  bool operator==(const AnalogueInput&) const = default;
};

/// A unit's registers, as for a chamber, and which of them are its inputs.
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

}  // namespace gyrotherm::drivers
