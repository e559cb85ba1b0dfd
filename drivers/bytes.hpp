/// Bytes of foreign frames as numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace gyrotherm {

[[nodiscard]] inline std::uint8_t byte_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<std::uint8_t>(bytes[at]);
}

}  // namespace gyrotherm
