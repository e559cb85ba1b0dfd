// SPDX-License-Identifier: Apache-2.0
/// The longest time of one exchange with a chamber.
#pragma once

#include <string>

#include "drivers/chamber/register_map.hpp"

namespace gyrotherm::drivers {

/// Returns the reason why a silent chamber on this link would look like a hung program to the guard of a run, or an
/// empty text. One call of the driver waits for a pause, and then for a late answer and for that of the next question.
/// The program sends no heartbeat after 2 s of it, and the guard acts after 8 s without one.
[[nodiscard]] std::string describe_slow_exchange(const MapLink& link);

}  // namespace gyrotherm::drivers
