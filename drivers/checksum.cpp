// SPDX-License-Identifier: Apache-2.0
#include "drivers/checksum.hpp"

#include <functional>
#include <numeric>

namespace gyrotherm::drivers {

namespace {

std::uint32_t mirrored(std::uint32_t value, int bits) {
  std::uint32_t image = 0;
  for (int i = 0; i < bits; ++i) image |= (value >> i & 1u) << (bits - 1 - i);
  return image;
}

}  // namespace

std::uint32_t crc(const Crc& model, std::span<const std::byte> bytes) {
  // The register is kept at the top of 32 bits, so that one loop serves every width.
  const int spare = 32 - model.width;
  const std::uint32_t polynomial = model.polynomial << spare;
  std::uint32_t value = model.initial << spare;
  for (const auto byte : bytes) {
    const auto next = std::to_integer<std::uint32_t>(byte);
    value ^= (model.reflected ? mirrored(next, 8) : next) << 24;
    for (int bit = 0; bit < 8; ++bit) value = value & 0x80000000u ? value << 1 ^ polynomial : value << 1;
  }
  value >>= spare;
  return (model.reflected_out.value_or(model.reflected) ? mirrored(value, model.width) : value) ^ model.final_xor;
}

std::uint8_t sum8(std::span<const std::byte> bytes) {
  unsigned sum = 0;
  for (const auto byte : bytes) sum += std::to_integer<unsigned>(byte);
  return static_cast<std::uint8_t>(sum);
}

std::uint16_t sum16(std::span<const std::byte> bytes, bool big_endian) {
  unsigned sum = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    sum += std::to_integer<unsigned>(bytes[i]) << ((i % 2 == 0) == big_endian ? 8 : 0);
  return static_cast<std::uint16_t>(sum);
}

std::uint8_t xor8(std::span<const std::byte> bytes) {
  return std::to_integer<std::uint8_t>(std::accumulate(bytes.begin(), bytes.end(), std::byte{}, std::bit_xor<>{}));
}

}  // namespace gyrotherm::drivers
