/// Any chamber that a register map describes.
#pragma once

#include <memory>

#include "drivers/chamber/register_map.hpp"
#include "drivers/instruments.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm {

/// Where the map allows one block, each read() checks the fingerprint too, and fails with mismatch if another unit
/// answers. head_for() fails with out_of_range, and writes nothing, if the register cannot hold the target. A map
/// without control describes a chamber that conditions whenever it is powered: start() has nothing to do, stop() is
/// refused.
[[nodiscard]] std::unique_ptr<Chamber> make_modbus_chamber(RegisterMap map, std::unique_ptr<Registers> registers);

}  // namespace gyrotherm
