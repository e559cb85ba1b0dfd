// SPDX-License-Identifier: Apache-2.0
/// Driver of a thermometer scanner with a text protocol that a file describes.
#pragma once

#include <memory>
#include <string>

#include "core/clock.hpp"
#include "drivers/instruments.hpp"
#include "drivers/thermometer/thermometer_description.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Returns the driver of the instrument on the selected link of the description. `place` names the instrument in its
/// faults. `clock` is the clock of the stream and must outlive the driver; null means the steady clock.
///
/// The first identify() also times one reading, and fails with timeout if an answer takes longer than the time limit of
/// the description.
///
/// On each connection the identity is asked first and must fit the description. The preparation follows, and is
/// repeated after each lost answer, because the instrument may have lost its settings. A late answer is never accepted
/// (TextClient). An input with an invalid reading has a fault and no value. If a question fails, its inputs and those
/// of the remaining questions have its fault; after a refusal, the remaining questions are asked.
[[nodiscard]] std::unique_ptr<Thermometer> make_text_thermometer(ThermometerDescription description,
                                                                 std::unique_ptr<ByteStream> stream, std::string place,
                                                                 const Clock* clock = nullptr);

}  // namespace gyrotherm::drivers
