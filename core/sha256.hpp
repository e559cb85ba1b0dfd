// SPDX-License-Identifier: Apache-2.0
/// The digest SHA-256 (FIPS 180-4), by which records, models and files are known.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace gyrotherm {

using Digest = std::array<std::uint8_t, 32>;

/// Takes bytes piece by piece; how they are cut makes no difference.
class Sha256 {
 public:
  void add(std::string_view bytes);
  /// The digest of everything that was added. Nothing may be added afterwards.
  [[nodiscard]] Digest digest();

 private:
  /// Works one block of 64 bytes into the state.
  void take(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> rest_{};  ///< the beginning of a block
  std::size_t rest_size_{};
  std::uint64_t size_{};
};

/// The digest as 64 hexadecimal digits.
[[nodiscard]] std::string hex(const Digest& digest);

/// The digest of a text, as 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view text);

}  // namespace gyrotherm
