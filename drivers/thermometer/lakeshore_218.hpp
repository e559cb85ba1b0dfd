// SPDX-License-Identifier: Apache-2.0
/// Lake Shore 218: eight thermometers on one line.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "core/clock.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// The user's manual (chapter 6) asks for 50 ms between communications. A reply of 73 characters takes 77 ms at 9600
/// baud; the reply to an unknown command never comes. A whole exchange ends within three times `within`.
struct Lakeshore218Timing {
  Duration within = std::chrono::milliseconds(500);  ///< for a whole reply
  Duration pause =
      std::chrono::milliseconds(50);  ///< the line must be silent this long before a query; 0 on the virtual rig
  const Clock* clock = nullptr;       ///< of a line with a time of its own
};

/// `place` names the instrument in its faults.
[[nodiscard]] std::unique_ptr<Thermometer> make_lakeshore_218(std::unique_ptr<ByteStream> line, std::string place,
                                                              Lakeshore218Timing timing = {});

}  // namespace gyrotherm::drivers
