// SPDX-License-Identifier: Apache-2.0
/// The server side of a power supply that a file describes.
#pragma once

#include <memory>

#include "drivers/chamber/register_map.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_supply.hpp"

namespace gyrotherm::simulator {

/// Returns a session that answers the lines of the supply on one of its links. `supply` must outlive the session.
[[nodiscard]] std::unique_ptr<Session> make_supply_session(VirtualSupply& supply, const drivers::MapLink& link);

}  // namespace gyrotherm::simulator
