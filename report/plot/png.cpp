// SPDX-License-Identifier: Apache-2.0
#include "report/plot/png.hpp"

#include <png.h>

#include <algorithm>
#include <cassert>

namespace gyrotherm::plot {
namespace {

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::string to_png(const Picture& picture) {
  assert(!picture.points.empty() && picture.points.size() == picture.columns * picture.rows);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.columns);
  image.height = static_cast<png_uint_32>(picture.rows);
  image.format = PNG_FORMAT_RGB;
  static_assert(sizeof(Rgb) == 3);
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');
  png_alloc_size_t size = bytes.size();
  [[maybe_unused]] const int written =
      png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.points.data(), 0, nullptr);
  assert(written != 0);
  bytes.resize(size);
  return bytes;
}

std::string base64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kAlphabet[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

}  // namespace gyrotherm::plot
