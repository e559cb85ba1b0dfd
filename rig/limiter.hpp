/// The chamber's own limiter: its sensor, its switch, its reset by hand. It is the safety function of a rig; this
/// program is none. What the rig file says of it belongs to the run's record.
#pragma once

#include <optional>
#include <string>

#include "core/quantity.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm {

struct Limiter {
  std::string protection_class;            ///< DIN 12880: "1", "2", "3.1" (over), "3.2" (under), "3.3" (both)
  std::optional<Celsius> lowest, highest;  ///< what it is set to; nothing: it does not look to that side
};

/// Of the table [chamber.limiter]; nothing if there is none. `lowest` and `highest` are the chamber's limits of the
/// rig: a limiter set inside them would trip in a run, and is a mistake.
[[nodiscard]] std::optional<Limiter> read_limiter(const TomlTable& chamber, Celsius lowest, Celsius highest);

/// "class 3.3, below -50 °C, above 75 °C": when it trips.
[[nodiscard]] std::string in_words(const Limiter& limiter);

}  // namespace gyrotherm
