#include "report/colour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrotherm {
namespace {

using Rgb = std::array<double, 3>;
constexpr std::array<Rgb, 5> kShades = {
    {{247, 250, 253}, {209, 225, 241}, {133, 180, 216}, {44, 115, 180}, {8, 48, 107}}};

}  // namespace

std::string palette(std::size_t index) {
  static constexpr std::array<const char*, 8> kPalette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                          "#e69f00", "#56b4e9", "#000000", "#7a5195"};
  return kPalette[index % kPalette.size()];
}

std::string shade(double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * (kShades.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kShades.size() - 2);
  const double part = place - static_cast<double>(below);
  std::array<int, 3> mixed{};
  for (std::size_t k = 0; k < 3; ++k) {
    mixed[k] = static_cast<int>(std::lround(kShades[below][k] + part * (kShades[below + 1][k] - kShades[below][k])));
  }
  return fmt::format("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2]);
}

bool shade_is_dark(double fraction) { return fraction > 0.6; }

}  // namespace gyrotherm
