/// The thermal image as coloured points.
#pragma once

#include "plot/png.hpp"
#include "thermal/thermal_image.hpp"

namespace gyrotherm {

/// The temperatures' colours, white where there is none, and the outlines of the parts.
[[nodiscard]] Picture coloured(const ThermalImage& image);

/// Where the isotherms lie, in °C: the multiples of the step within the samples' range.
[[nodiscard]] std::vector<double> isotherm_levels(const ThermalImage& image);

/// Draws the isotherms into the picture, then a dot and a letter at each thermometer.
void draw_isotherms(Picture& picture, const ThermalImage& image);
void draw_marks(Picture& picture, const ThermalImage& image);

}  // namespace gyrotherm
