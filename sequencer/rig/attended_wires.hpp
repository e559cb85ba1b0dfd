// SPDX-License-Identifier: Apache-2.0
/// The wires of a virtual rig to instruments of its own: lines within the process, below the drivers of a real rig.
#pragma once

#include <memory>

#include "core/quantity.hpp"
#include "sequencer/rig/rig.hpp"
#include "simulator/virtual_instruments.hpp"

namespace gyrotherm::rig {

/// `instruments` are attended: each question is answered in the thread that puts it, before it waits for the answer.
/// The clock stands at `already` − 1 s, and its days are `later`.
[[nodiscard]] std::unique_ptr<Wires> make_attended_wires(std::unique_ptr<simulator::VirtualInstruments> instruments,
                                                         Duration already, Duration later);

}  // namespace gyrotherm::rig
