// SPDX-License-Identifier: Apache-2.0
/// Any chamber that a register map describes.
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

/// `registers` are those of the map's link in use. Where the map allows one block, each read() checks the fingerprint
/// too, and fails with mismatch if another unit answers; what the map calls a sentinel, or says cannot be, is
/// out_of_range. State and alarms are asked for as often as the map says, and are then those of the last time; a
/// register of theirs that the unit refuses is not asked for again.
///
/// identify() fails with mismatch, too, if the controller is set to fewer decimals than set points need to keep within
/// set_point_tolerance(): what it shows would pass for somebody else's.
///
/// read() fails with out_of_range, too, if the air is what no chamber's air is: outside −120 … 250 °C, next to nothing
/// where it was not near zero before, or farther from the last reading than air moves meanwhile. What jumped and stays
/// where it jumped to in three readings is what the sensor shows, and the interlocks judge it.
///
/// `before`: the controller's settings as another program has read them, which count where they cannot be read: for a
/// chamber that is to be made safe.
///
/// send_set_point() fails with out_of_range, and writes nothing, if the register cannot hold the target or the map or
/// the controller limits it. start(), stop() and perform() carry out the map's command of that name, which waits for
/// the registers that show that it took effect. A map with neither commands nor [control] describes a chamber that
/// conditions whenever it is powered: start() has nothing to do, stop() is refused.
[[nodiscard]] std::unique_ptr<Chamber> make_modbus_chamber(RegisterMap map, std::unique_ptr<Registers> registers,
                                                           std::unique_ptr<Pauses> pauses = real_pauses(),
                                                           const ControllerSettings& before = {});

}  // namespace gyrotherm::drivers
