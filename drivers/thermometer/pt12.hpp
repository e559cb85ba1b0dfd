// SPDX-License-Identifier: Apache-2.0
/// RH Systems PT12: twelve platinum thermometers on one serial line. Text ↔ values, both ends of the line (manual of
/// 7/20/2021, chapter 5), and who asks. Lines come without their CR LF.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

inline constexpr std::size_t kPt12Inputs = 12;

/// "25.38095, 25.26928, NaN, …" → twelve readings of `T?`. Numbers are standard or scientific; blanks may stand around
/// them. NaN, in any case, is an input without a probe: out_of_range in its place, like a reading that no platinum
/// thermometer has (IEC 60751: −200 to 850 °C). Inputs are named "T1" to "T12". Fails with corrupted if the line is not
/// twelve numbers.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_pt12_temperatures(std::string_view line);

/// The instrument's side; an absent reading is an input without a probe.
[[nodiscard]] std::string encode_pt12_temperatures(std::span<const std::optional<double>> celsius);

/// The manual states no times. An answer of about 130 characters takes 140 ms at 9600 baud.
struct Pt12Timing {
  Duration within = std::chrono::milliseconds(500);  ///< for a whole answer
  Duration pause = std::chrono::milliseconds(10);    ///< the line must be silent this long before a question
  const Clock* clock = nullptr;                      ///< of a line with a time of its own
};

/// Identifies itself by its serial number. `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_pt12(std::unique_ptr<ByteStream> line, std::string place,
                                                     Pt12Timing timing = {});

}  // namespace gyrotherm::drivers
