// SPDX-License-Identifier: Apache-2.0
/// Which of a description's fields are the gyro's axes, and which are its housekeeping.
#pragma once

#include <string>
#include <vector>

#include "core/toml_reader.hpp"
#include "drivers/gyro/frame_fields.hpp"
#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

/// The words of a file for the roles.
inline constexpr auto kFieldRoles = words_in_order<FieldRole::pulse_count, FieldRole::value>(
    "pulse_count", "increment", "rate", "integrated_angle", "sequence", "timestamp", "status", "temperature", "value");

/// Gives the fields of `format`, which have all been read, their axes and slots: `wanted` as read_frame_format has it,
/// the file's own choice in `table`. Mistakes are noted in `table`, or in the field's own of `fields`: an axis that
/// does not exist or is wanted twice; two fields that one frame has and that are the same to the record; fields of one
/// axis, or of one name, that differ in what they mean; a name of housekeeping that is none.
void settle_roles(const TomlTable& table, const std::vector<TomlTable>& fields, const std::vector<std::string>& wanted,
                  FrameFormat& format);

}  // namespace gyrotherm::drivers
