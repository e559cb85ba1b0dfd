// SPDX-License-Identifier: Apache-2.0
/// The frame of the virtual gyro, as described in profiles/rigs/virtual.toml.
#pragma once

#include <stdexcept>

#include "drivers/gyro/frame_format.hpp"

namespace gyrotherm::drivers {

inline constexpr const char* kVirtualGyroFrame = R"([frame]
name = "virtual-gyro"
sync = [0xA5, 0x5A]
length = 16

[[frame.field]]
role = "sequence"
type = "u16"
offset = 2
endian = "little"

[[frame.field]]
role = "timestamp"
type = "u32"
offset = 4
endian = "little"
unit = "us"

[[frame.field]]
role = "pulse_count"
type = "i32"
offset = 8
endian = "little"

[[frame.field]]
role = "status"
type = "u8"
offset = 12
mask = 0xFF
good = 0

[frame.check]
kind = "crc16"
from = 0
offset = 14
endian = "little"
polynomial = 0x1021
initial = 0xFFFF
reflected = false
final_xor = 0
)";

[[nodiscard]] inline FrameFormat frame_format_of(const char* text) {
  const auto file = TomlTable::parse(text, "frame.toml");
  if (!file) throw std::runtime_error(gyrotherm::text(file.error()));
  auto format = read_frame_format(file->table("frame"));
  if (const auto verdict = file->verdict(); !verdict) throw std::runtime_error(gyrotherm::text(verdict.error()));
  return format;
}

[[nodiscard]] inline FrameFormat virtual_gyro_frame() { return frame_format_of(kVirtualGyroFrame); }

}  // namespace gyrotherm::drivers
