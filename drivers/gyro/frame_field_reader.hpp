/// Reads the [[frame.field]] tables of a gyro's frame description.
#pragma once

#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm {

/// One field of `format`, of which everything but the fields is known. Mistakes are noted in the table.
[[nodiscard]] FrameField read_frame_field(const TomlTable& table, const FrameFormat& format);

/// Whole numbers from 0 to `highest`.
[[nodiscard]] std::vector<std::uint32_t> read_whole_numbers(const TomlTable& table, const char* key, double highest,
                                                            const char* what);

/// The words of roles, for messages.
[[nodiscard]] const char* name(FieldRole role);

}  // namespace gyrotherm
