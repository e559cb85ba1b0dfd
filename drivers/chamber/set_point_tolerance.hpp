/// How far from the set point that was sent a chamber may show it: one answer for a run's interlocks, for its safe
/// sequence and for gyrotherm-make-safe.
#pragma once

#include "core/quantity.hpp"
#include "drivers/chamber/register_map.hpp"

namespace gyrotherm {

/// What a controller may make of a set point: its register's resolution or, if that is more, what the map tolerates; a
/// tenth of a kelvin at least.
[[nodiscard]] Kelvins set_point_tolerance(const RegisterMap& map);

}  // namespace gyrotherm
