// SPDX-License-Identifier: Apache-2.0
/// Pictures of coloured pixels, and their encoding as PNG.
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
  std::vector<Rgb> points;  ///< row by row from the top
  [[nodiscard]] Rgb& at(std::size_t row, std::size_t column) { return points[row * columns + column]; }
};

/// Returns the picture as a PNG file: 8 bits per channel, no alpha, no time stamp or other varying data. `picture` must
/// not be empty.
[[nodiscard]] std::string to_png(const Picture& picture);

/// Encodes bytes in base64 (RFC 4648), as in data URIs.
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace gyrotherm::plot
