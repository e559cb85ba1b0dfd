/// Check values over bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace gyrotherm {

/// A cyclic redundancy check in the Rocksoft model (R. Williams, "A painless guide to CRC error detection algorithms",
/// 1993), reflected in and out alike. CRC-16/XMODEM is {16, 0x1021}; its value of "123456789" is 31C3.
struct Crc {
  int width{};  ///< 16 or 32
  std::uint32_t polynomial{};
  std::uint32_t initial{};
  bool reflected{};
  std::uint32_t final_xor{};
};
[[nodiscard]] std::uint32_t crc(const Crc& model, std::span<const std::byte> bytes);

/// The sum modulo 256.
[[nodiscard]] std::uint8_t sum8(std::span<const std::byte> bytes);
/// All bytes by exclusive or.
[[nodiscard]] std::uint8_t xor8(std::span<const std::byte> bytes);

}  // namespace gyrotherm
