// SPDX-License-Identifier: Apache-2.0
/// The identities that served virtual instruments report, so that a client can distinguish them from real ones
/// (drivers/virtual_identity.hpp).
#pragma once

#include "simulator/chamber_registers.hpp"
#include "simulator/virtual_instruments.hpp"

namespace gyrotherm::simulator {

/// Returns the unit with a marked identity: its text contains the serial number of virtual instruments, and its item
/// `serial_number` is their integer. An item remains unchanged if it is too short, if it ends in a decimal fraction, or
/// if its pattern excludes the mark.
[[nodiscard]] SimulatedUnit mark_identity(SimulatedUnit unit, const drivers::RegisterMap& map);

/// Marks the identities of thermometers, supplies and gyros, as far as their protocols and descriptions permit.
void mark_identities(VirtualInstrumentsOptions& options);

}  // namespace gyrotherm::simulator
