/// How sure a register map is of what the program uses of it. Pure.
#pragma once

#include <string>
#include <vector>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

struct Doubt {
  std::string item;
  Confidence confidence{};
  std::string note;
};

/// The items that reading, set points, commands, states, alarms, limits, the fingerprint and the profile memory use,
/// and that nobody has verified on the instrument; the least sure first.
[[nodiscard]] std::vector<Doubt> doubts(const RegisterMap& map);

/// A line for people: "3 registers in use verified, 5 from the manual, 1 from one source (…), 1 unverified: set_point
/// (…)".
[[nodiscard]] std::string confidence_in_words(const RegisterMap& map);

}  // namespace gyrotherm
