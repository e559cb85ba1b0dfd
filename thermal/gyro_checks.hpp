/// Inner step of reading a gyro file: whether its parts fit together.
#pragma once

#include "core/toml_reader.hpp"
#include "thermal/gyro_model.hpp"

namespace gyrotherm {

/// Notes each mistake at the key of `root` that it stands at. The sizes are above zero.
void check_geometry(const TomlTable& root, const GyroModel& model);

}  // namespace gyrotherm
