// SPDX-License-Identifier: Apache-2.0
/// RH Systems PT12, twelve platinum thermometers on one serial line: the encoding for host and instrument (manual of
/// 7/20/2021, chapter 5), and the driver. Lines are given without CR LF.
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

/// Decodes "25.38095, 25.26928, NaN, …", the answer to `T?`, to twelve readings. Numbers are in standard or scientific
/// notation; blanks around them are ignored. NaN, in upper or lower case, means an input without a probe. An input is
/// out_of_range if it has no probe, or if its temperature is outside the range of platinum thermometers (IEC 60751:
/// −200 to 850 °C). Inputs are named "T1" to "T12". Fails with corrupted if the line is not twelve numbers.
[[nodiscard]] Result<std::vector<Result<Celsius>>> decode_pt12_temperatures(std::string_view line);

/// Instrument: encodes readings. An empty reading means an input without a probe.
[[nodiscard]] std::string encode_pt12_temperatures(std::span<const std::optional<double>> celsius);

/// Timing of the exchange. The manual specifies no times. An answer of about 130 characters takes 140 ms at 9600 baud.
struct Pt12Timing {
  /// Time limit for a complete answer.
  Duration within = std::chrono::milliseconds(500);
  /// Required silence before a question.
  Duration pause = std::chrono::milliseconds(10);
  /// Clock of the line; null means the steady clock.
  const Clock* clock = nullptr;
};

/// Returns the driver. Its identity contains the serial number. `place` names the instrument in its
/// faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_pt12(std::unique_ptr<ByteStream> line, std::string place,
                                                     Pt12Timing timing = {});

}  // namespace gyrotherm::drivers
