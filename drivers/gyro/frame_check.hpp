// SPDX-License-Identifier: Apache-2.0
/// The check of a gyro's frame: what is summed up, how, and where the sum is kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/toml_reader.hpp"
#include "drivers/checksum.hpp"

namespace gyrotherm::drivers {

/// sum16: of 16-bit words in the byte order of the check. Parity: of all bits covered, the bit itself among them.
enum class CheckKind { none, sum8, sum16, xor8, crc, odd_parity, even_parity };

/// Positions count from the frame's start, or (negative) from its end. In a line of text the check is hexadecimal
/// digits after `LineFormat::mark`, covers what lies before the mark, and has no position of its own.
struct FrameCheck {
  CheckKind kind = CheckKind::none;
  std::ptrdiff_t from{};    ///< first byte covered
  std::ptrdiff_t offset{};  ///< of the stored check
  std::ptrdiff_t to{};      ///< end of what is covered; by default where the check is stored
  bool big_endian{};
  Crc model{};                ///< crc
  std::size_t padded_to = 1;  ///< what is covered is filled up with zeros to a multiple of this, for the sum alone
  unsigned bit{};             ///< parity: which bit of the byte at `offset`
  std::uint32_t mask = 0xFFFFFFFF;  ///< bits of the check that are compared
};

[[nodiscard]] std::size_t byte_count(const FrameCheck& check);  ///< of the stored check
/// A [frame.check] table; `shortest`: of the frames that it must fit in, bytes. In a line nothing has a position.
[[nodiscard]] FrameCheck read_frame_check(const TomlTable& table, std::size_t shortest, bool in_line);

/// The check of these bytes, all of them covered.
[[nodiscard]] std::uint32_t check_value(const FrameCheck& check, std::span<const std::byte> covered);
[[nodiscard]] bool passes(const FrameCheck& check, std::span<const std::byte> frame);
/// Writes the check that makes the frame pass.
void seal(const FrameCheck& check, std::span<std::byte> frame);

}  // namespace gyrotherm::drivers
