/// Reads a gyro file (profiles/gyros/*.toml, schema "gyrotherm-gyro/1").
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"
#include "core/toml_reader.hpp"
#include "thermal/gyro_model.hpp"

namespace gyrotherm {

/// Notes each mistake at the key of `root` that it stands at. The sizes are above zero.
void check_geometry(const TomlTable& root, const GyroModel& model);

/// Fails with bad_file, every mistake with its place: sizes that are not above zero, parts that overlap or leave the
/// cabinet, a thermometer off the block, powers that contradict rate × volume.
[[nodiscard]] Result<GyroModel> parse_gyro(std::string_view text, const std::string& file);

}  // namespace gyrotherm
