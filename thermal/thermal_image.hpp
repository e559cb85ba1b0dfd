/// The thermal image of the gyro: a plane through it with isotherms and thermometers, as the paper's Figures 1 and 2.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plot/axis.hpp"
#include "plot/isotherms.hpp"

namespace gyrotherm {

/// A thermometer on the plane.
struct ThermalMark {
  std::string name;
  double x_mm{}, y_mm{};
  double celsius{};
};

struct ThermalImage {
  std::string title;                ///< "Top face of the block, z = 52.5 mm"
  std::string x_title, y_title;     ///< "x, mm"
  Range x_mm, y_mm;                 ///< that the samples cover; y points upwards
  SampledField celsius;             ///< top row first; NaN is left white
  std::vector<std::uint8_t> parts;  ///< of each sample, what it lies in: a line is drawn where it changes
  Range colours_c;                  ///< temperatures of the first and the last colour
  double isotherm_step_k = 0.5;
  std::vector<ThermalMark> marks;
  bool simulated = false;
};

/// As an SVG document with axes, a colour bar and labelled isotherms; the colours themselves are a PNG inside it.
[[nodiscard]] std::string svg_of(const ThermalImage& image);

/// As the bytes of a PNG, one point per sample: colours, parts, isotherms, and the thermometers with their letters.
[[nodiscard]] std::string png_of(const ThermalImage& image);

}  // namespace gyrotherm
