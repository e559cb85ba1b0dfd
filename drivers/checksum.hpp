// SPDX-License-Identifier: Apache-2.0
/// Checksums, and access to bytes as numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace gyrotherm::drivers {

/// Returns the byte at index `at` as a number.
[[nodiscard]] inline std::uint8_t byte_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::uint8_t>(bytes[at]);
}

/// Parameters of a cyclic redundancy check in the Rocksoft model (R. Williams, "A painless guide to CRC error detection
/// algorithms", 1993). CRC-16/XMODEM is {16, 0x1021}; its value for "123456789" is 31C3.
struct Crc {
  int width{};  ///< bits, 3 to 32
  std::uint32_t polynomial{};
  std::uint32_t initial{};
  /// Bytes are processed with the lowest bit first.
  bool reflected{};
  std::uint32_t final_xor{};
  /// The result is bit-reversed; if empty, as in `reflected`.
  std::optional<bool> reflected_out{};
};
[[nodiscard]] std::uint32_t crc(const Crc& model, std::span<const std::byte> bytes);

/// Returns the sum of the bytes modulo 256.
[[nodiscard]] std::uint8_t sum8(std::span<const std::byte> bytes);
/// Returns the sum of the 16-bit words modulo 65536. An odd last byte is padded with a zero byte.
[[nodiscard]] std::uint16_t sum16(std::span<const std::byte> bytes, bool big_endian);
/// Returns the Fletcher checksum: a is the sum of the bytes, b is the sum of all values of a, both modulo `modulus`; b
/// is the high byte. With 256 it is the 8-bit checksum of RFC 1145, with 255 it is Fletcher-16 (J. G. Fletcher, "An
/// arithmetic checksum for serial transmissions", 1982).
[[nodiscard]] std::uint16_t fletcher(std::span<const std::byte> bytes, unsigned modulus);
/// Returns the exclusive or of all bytes.
[[nodiscard]] std::uint8_t xor8(std::span<const std::byte> bytes);

}  // namespace gyrotherm::drivers
