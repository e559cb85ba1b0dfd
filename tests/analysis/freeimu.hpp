/// The public two-thermometer record of a real gyro (MIT licence, not carried here), where the machine has it.
#pragma once

#include <optional>

#include "analysis/data/dataset.hpp"

namespace gyrotherm {

enum class FreeImuAxis { x, y, z };

/// Thermometers "die" and "barometer", bias in °/h; nothing without GYROTHERM_SHARED in the environment.
[[nodiscard]] std::optional<Dataset> load_freeimu(FreeImuAxis axis);

}  // namespace gyrotherm
