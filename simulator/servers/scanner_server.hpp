// SPDX-License-Identifier: Apache-2.0
/// The server side of a thermometer scanner that a file describes.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "drivers/thermometer/thermometer_description.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Returns a session that answers the lines of the description on its selected link. `inputs` are indices of the
/// laboratory's thermometers. Readings are answered only after all lines of the preparation and the commands that
/// precede the question, because the settings of the instrument are unknown before. An input without a thermometer,
/// or with a dead one, has the invalid reading and status of the table [simulated]. Any other line has the answer for
/// unknown lines. `laboratory` must outlive the session.
[[nodiscard]] std::unique_ptr<Session> make_scanner_session(const VirtualLaboratory& laboratory,
                                                            const drivers::ThermometerDescription& description,
                                                            std::vector<std::size_t> inputs);

}  // namespace gyrotherm::simulator
