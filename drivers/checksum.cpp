// SPDX-License-Identifier: Apache-2.0
#include "drivers/checksum.hpp"

#include <array>
#include <functional>
#include <map>
#include <numeric>

namespace gyrotherm::drivers {

namespace {

std::uint32_t mirror_bits(std::uint32_t value, int bits) {
  std::uint32_t image = 0;
  for (int i = 0; i < bits; ++i) image |= (value >> i & 1u) << (bits - 1 - i);
  return image;
}

using ByteTable = std::array<std::uint32_t, 256>;

ByteTable make_mirror_table() {
  ByteTable table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) table[byte] = mirror_bits(byte, 8);
  return table;
}

/// Returns the register after eight shifts, for each byte at the top of 32 bits.
ByteTable make_shift_table(std::uint32_t polynomial) {
  ByteTable table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    auto value = byte << 24;
    for (int bit = 0; bit < 8; ++bit) value = value & 0x80000000u ? value << 1 ^ polynomial : value << 1;
    table[byte] = value;
  }
  return table;
}

/// Returns the table of a polynomial. Each thread computes a table once; a rig needs one per kind of instrument.
const ByteTable& find_table(std::uint32_t polynomial) {
  constexpr std::size_t kMostTables = 16;
  thread_local std::map<std::uint32_t, ByteTable> tables;
  const auto found = tables.find(polynomial);
  if (found == tables.end() && tables.size() == kMostTables) tables.clear();
  return found != tables.end() ? found->second : tables.emplace(polynomial, make_shift_table(polynomial)).first->second;
}

}  // namespace

std::uint32_t crc(const Crc& model, std::span<const std::byte> bytes) {
  // The register occupies the top of 32 bits, so the same loop works for every width.
  static const ByteTable kMirrored = make_mirror_table();
  const int spare = 32 - model.width;
  const auto& table = find_table(model.polynomial << spare);
  std::uint32_t value = model.initial << spare;
  for (const auto byte : bytes) {
    const auto next = std::to_integer<std::uint32_t>(byte);
    value = value << 8 ^ table[value >> 24 ^ (model.reflected ? kMirrored[next] : next)];
  }
  value >>= spare;
  return (model.reflected_out.value_or(model.reflected) ? mirror_bits(value, model.width) : value) ^ model.final_xor;
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

std::uint16_t fletcher(std::span<const std::byte> bytes, unsigned modulus) {
  unsigned sum = 0, sum_of_sums = 0;
  for (const auto byte : bytes) {
    sum = (sum + std::to_integer<unsigned>(byte)) % modulus;
    sum_of_sums = (sum_of_sums + sum) % modulus;
  }
  return static_cast<std::uint16_t>(sum_of_sums << 8 | sum);
}

std::uint8_t xor8(std::span<const std::byte> bytes) {
  return std::to_integer<std::uint8_t>(std::accumulate(bytes.begin(), bytes.end(), std::byte{}, std::bit_xor<>{}));
}

}  // namespace gyrotherm::drivers
