// SPDX-License-Identifier: Apache-2.0
/// A picture of coloured points, and its bytes as PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::plot {

struct Rgb {
  std::uint8_t red{}, green{}, blue{};
};

struct Picture {
  std::size_t columns{};
  std::size_t rows{};
  std::vector<Rgb> points;  ///< rows × columns, top row first
  [[nodiscard]] Rgb& at(std::size_t row, std::size_t column) { return points[row * columns + column]; }
};

/// The file's bytes: 8 bits a channel, no alpha, nothing that varies from run to run. `picture` must not be empty.
[[nodiscard]] std::string png_of(const Picture& picture);

/// The bytes in base64 (RFC 4648), as data URIs carry them.
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace gyrotherm::plot
