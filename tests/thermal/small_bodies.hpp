/// Bodies small enough to be known exactly, and the shipped gyros.
#pragma once

#include <string>
#include <vector>

#include "thermal/gyro_model.hpp"
#include "thermal/mesh.hpp"

namespace gyrotherm {

/// profiles/gyros/NAME.toml.
[[nodiscard]] std::string gyro_text(const std::string& name);
[[nodiscard]] GyroModel shipped_gyro(const std::string& name);

/// From 0 to `length` in equal pieces.
[[nodiscard]] std::vector<double> even_lines(double length, int pieces);

/// One box of one part, with film on the faces given (−x, +x, −y, +y, −z, +z).
[[nodiscard]] GyroMesh box_of(GyroPart part, std::vector<double> x, std::vector<double> y, std::vector<double> z,
                              const std::vector<int>& film_faces);

/// A model of nothing but materials: every one with these properties.
[[nodiscard]] GyroModel uniform_model(const MaterialProperties& properties);

}  // namespace gyrotherm
