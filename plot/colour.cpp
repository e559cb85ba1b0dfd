#include "plot/colour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace gyrotherm {
namespace {

constexpr std::array<Rgb, 5> kShades = {
    {{247, 250, 253}, {209, 225, 241}, {133, 180, 216}, {44, 115, 180}, {8, 48, 107}}};
constexpr std::array<Rgb, 11> kHeats = {{{49, 54, 149},
                                         {69, 117, 180},
                                         {116, 173, 209},
                                         {171, 217, 233},
                                         {224, 243, 248},
                                         {255, 255, 191},
                                         {254, 224, 144},
                                         {253, 174, 97},
                                         {244, 109, 67},
                                         {215, 48, 39},
                                         {165, 0, 38}}};

std::uint8_t between(std::uint8_t from, std::uint8_t to, double part) {
  return static_cast<std::uint8_t>(std::lround(from + part * (to - from)));
}

Rgb mixed(std::span<const Rgb> stops, double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), stops.size() - 2);
  const double part = place - static_cast<double>(below);
  const Rgb &a = stops[below], &b = stops[below + 1];
  return {between(a.red, b.red, part), between(a.green, b.green, part), between(a.blue, b.blue, part)};
}

}  // namespace

std::string palette(std::size_t index) {
  static constexpr std::array<const char*, 8> kPalette = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                          "#e69f00", "#56b4e9", "#000000", "#7a5195"};
  return kPalette[index % kPalette.size()];
}

std::string shade(double fraction) {
  const Rgb rgb = mixed(kShades, fraction);
  return fmt::format("#{:02x}{:02x}{:02x}", rgb.red, rgb.green, rgb.blue);
}

Rgb heat(double fraction) { return mixed(kHeats, fraction); }

bool shade_is_dark(double fraction) { return fraction > 0.6; }

}  // namespace gyrotherm
