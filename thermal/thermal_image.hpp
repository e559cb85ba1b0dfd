// SPDX-License-Identifier: Apache-2.0
/// The thermal image of the gyro: a plane through it with isotherms and thermometers, as the paper's Figures 1 and 2.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "plot/isotherms.hpp"
#include "plot/plot.hpp"
#include "plot/png.hpp"
#include "thermal/gyro_parts.hpp"
#include "thermal/mesh.hpp"

namespace gyrotherm::thermal {

/// Keeps references: model, mesh and field must outlive it. Coordinates in m, in the cabinet's axes.
class ThermalField {
 public:
  ThermalField(const GyroModel& model, const GyroMesh& mesh, const Eigen::VectorXd& field_c);

  /// As the elements interpolate it, °C; NaN outside of the mesh.
  [[nodiscard]] double temperature_at(double x, double y, double z) const;

  /// By the parts' true shapes, not by the bricks; nothing outside of everything.
  [[nodiscard]] std::optional<GyroPart> part_at(double x, double y, double z) const;

 private:
  const GyroModel& model_;
  const GyroMesh& mesh_;
  const Eigen::VectorXd& field_c_;
  GyroParts parts_;
};

/// A thermometer on the plane.
struct ThermalMark {
  std::string name;
  double x_mm{}, y_mm{};
  double celsius{};
};

struct ThermalImage {
  std::string title;                ///< "Top face of the block, z = 52.5 mm"
  std::string x_title, y_title;     ///< "x, mm"
  plot::Range x_mm, y_mm;           ///< that the samples cover; y points upwards
  plot::SampledField celsius;       ///< top row first; NaN is left white
  std::vector<std::uint8_t> parts;  ///< of each sample, what it lies in: a line is drawn where it changes
  plot::Range colours_c;            ///< temperatures of the first and the last colour
  double isotherm_step_k = 0.5;
  std::vector<ThermalMark> marks;
  bool simulated = false;
};

/// As an SVG document with axes, a colour bar and labelled isotherms; the colours themselves are a PNG inside it.
[[nodiscard]] std::string svg_of(const ThermalImage& image);

/// The temperatures' colours, white where there is none, and the outlines of the parts.
[[nodiscard]] plot::Picture coloured(const ThermalImage& image);

/// Where the isotherms lie, in °C: the multiples of the step within the samples' range.
[[nodiscard]] std::vector<double> isotherm_levels(const ThermalImage& image);

}  // namespace gyrotherm::thermal
