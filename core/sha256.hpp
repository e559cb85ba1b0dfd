/// SHA-256 (FIPS 180-4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace gyrotherm {

using Digest = std::array<std::uint8_t, 32>;

class Sha256 {
 public:
  void add(std::string_view bytes);
  /// Of everything added; nothing may be added after.
  [[nodiscard]] Digest digest();

 private:
  void take(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> rest_{};  ///< the beginning of a block
  std::size_t rest_size_{};
  std::uint64_t size_{};
};

/// 64 hexadecimal digits.
[[nodiscard]] std::string hex(const Digest& digest);

/// Of a text, in hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace gyrotherm
