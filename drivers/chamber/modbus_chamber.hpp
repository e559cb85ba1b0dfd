// SPDX-License-Identifier: Apache-2.0
/// Driver for chambers that are described by a register map.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::drivers {

/// Returns the driver. `registers` must belong to the map's selected link. If the map has `one_block`, each read() also
/// checks the fingerprint, and fails with mismatch if another unit answers. A sentinel, or a value outside the map's
/// limits, is out_of_range. State and alarms are read as often as the map specifies; between these readings, read()
/// returns their latest values. A status register that the unit refuses is not read again.
///
/// If the map reads humidity, it is read with state and alarms. The dew point is that of the unit, or else computed
/// from the humidity and the air temperature. If only the humidity cannot be read, both are unknown and read()
/// succeeds.
///
/// identify() also fails with mismatch if the controller is set to so few decimals that the step of its set points
/// exceeds set_point_tolerance(), because a rounded set point would be mistaken for one from another program.
///
/// read() also fails with out_of_range for a set point beyond ±1000 °C, and for an impossible air temperature: outside
/// −120 … 250 °C, almost zero although the air was not near zero before, or changed faster than air can change. A value
/// that persists for three readings after such a jump is accepted as the sensor's output; the interlocks then evaluate
/// it.
///
/// `before` contains the controller's settings that another program has read. They are used if a chamber must be made
/// safe and its settings cannot be read.
///
/// send_set_point() fails with out_of_range, without writing, if the register cannot hold the target, or if the map or
/// the controller limits it. start(), stop() and perform() execute the map's command of that name, which waits until
/// the registers show its effect. A map with neither commands nor [control] describes a chamber that controls whenever
/// it is powered: start() does nothing, and stop() is refused.
[[nodiscard]] std::unique_ptr<Chamber> make_modbus_chamber(RegisterMap map, std::unique_ptr<Registers> registers,
                                                           std::unique_ptr<Pauses> pauses = make_real_pauses(),
                                                           const ControllerSettings& before = {});

}  // namespace gyrotherm::drivers
