// SPDX-License-Identifier: Apache-2.0
/// Which word orders make sense of what a unit holds: a setting of some controllers that their manuals are not sure of.
/// Pure.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "drivers/chamber/register_item.hpp"

namespace gyrotherm::drivers {

/// What chambers do.
struct PlausibleCelsius {
  double lowest = -200, highest = 400;
};

struct OrderFinding {
  WordOrder order{};
  double air_c{}, set_point_c{};  ///< as this order reads them; NaN where it reads no number
  bool plausible{};               ///< both are numbers that a chamber can have, and neither is next to nothing
};

/// All four orders of the two items' words, the items' own first. Empty for items of one register: there is no order to
/// find. A value below 10⁻⁴ of a degree that is not zero is the trace of a wrong order, not a temperature.
[[nodiscard]] std::vector<OrderFinding> probe_word_order(const RegisterItem& air,
                                                         std::span<const std::uint16_t> air_words,
                                                         const RegisterItem& set_point,
                                                         std::span<const std::uint16_t> set_point_words,
                                                         const PlausibleCelsius& range = {});

/// For people: "word order cdab fits (air 23.41 °C, set point 20.00 °C)", or what to change.
[[nodiscard]] std::string in_words(const std::vector<OrderFinding>& findings);

[[nodiscard]] const char* name(WordOrder order);

}  // namespace gyrotherm::drivers
