// SPDX-License-Identifier: Apache-2.0
/// Bytes of foreign frames as numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace gyrotherm::drivers {

[[nodiscard]] inline std::uint8_t byte_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::uint8_t>(bytes[at]);
}

// Check values over bytes.

/// A cyclic redundancy check in the Rocksoft model (R. Williams, "A painless guide to CRC error detection algorithms",
/// 1993). CRC-16/XMODEM is {16, 0x1021}; its value of "123456789" is 31C3.
struct Crc {
  int width{};  ///< 3 to 32
  std::uint32_t polynomial{};
  std::uint32_t initial{};
  bool reflected{};  ///< bytes enter with their lowest bit first
  std::uint32_t final_xor{};
  std::optional<bool> reflected_out{};  ///< the result is mirrored; by default as `reflected`
};
[[nodiscard]] std::uint32_t crc(const Crc& model, std::span<const std::byte> bytes);

/// The sum modulo 256.
[[nodiscard]] std::uint8_t sum8(std::span<const std::byte> bytes);
/// The sum of 16-bit words modulo 65536; an odd last byte counts as a word with a zero behind it.
[[nodiscard]] std::uint16_t sum16(std::span<const std::byte> bytes, bool big_endian);
/// All bytes by exclusive or.
[[nodiscard]] std::uint8_t xor8(std::span<const std::byte> bytes);

}  // namespace gyrotherm::drivers
