// SPDX-License-Identifier: Apache-2.0
/// RH Systems PT12, twelve platinum thermometers on one serial line: text ↔ values, both ends of the line (manual of
/// 7/20/2021, chapter 5). Lines come without their CR LF.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kPt12Inputs = 12;

/// "25.38095, 25.26928, NaN, …" → twelve readings of `T?`. Numbers are standard or scientific; blanks may stand around
/// them. NaN, in any case, is an input without a probe: out_of_range in its place, like a reading that no platinum
/// thermometer has (IEC 60751: −200 to 850 °C). Inputs are named "T1" to "T12". Fails with corrupted if the line is not
/// twelve numbers.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_pt12_temperatures(std::string_view line);

/// The instrument's side; an absent reading is an input without a probe.
[[nodiscard]] std::string encode_pt12_temperatures(std::span<const std::optional<double>> celsius);

}  // namespace gyrotherm::drivers
