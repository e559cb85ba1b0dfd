// SPDX-License-Identifier: Apache-2.0
/// RH Systems PT12: twelve platinum thermometers on one line.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "core/clock.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

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
