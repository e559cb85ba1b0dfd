// SPDX-License-Identifier: Apache-2.0
#include "apps/thermal/thermal_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulator/thermal/assembly.hpp"

namespace gyrotherm::app {
namespace {

/// Depth of the sampled plane below a face.
constexpr double kDepth_mm = 0.05;
/// Margin around the block.
constexpr double kMargin_mm = 2;

/// A plane through the cabinet.
struct Plane {
  std::string file, title, x_title, y_title;
  plot::Range right_mm, up_mm;
  std::array<double, 3> origin_mm{}, along_right{}, along_up{};

  /// Converts coordinates in the plane, mm, to a point in the cabinet, m.
  [[nodiscard]] std::array<double, 3> point_m(double right, double up) const {
    std::array<double, 3> point{};
    for (std::size_t k = 0; k < 3; ++k) point[k] = 1e-3 * (origin_mm[k] + right * along_right[k] + up * along_up[k]);
    return point;
  }
};

Plane top_face(const thermal::GyroGeometry& geometry) {
  const auto [x, y, z] = geometry.cabinet;
  const double top = z / 2 + geometry.block_thickness / 2;
  return {"top-face",
          fmt::format("Top face of the block, z = {:g} mm", top),
          "x, mm",
          "y, mm",
          {0, x},
          {0, y},
          {0, 0, top - kDepth_mm},
          {1, 0, 0},
          {0, 1, 0}};
}

std::vector<Plane> view_planes(const thermal::GyroGeometry& geometry) {
  const auto [x, y, z] = geometry.cabinet;
  return {top_face(geometry),
          {"bores",
           fmt::format("Plane of the bores, z = {:g} mm", z / 2),
           "x, mm",
           "y, mm",
           {0, x},
           {0, y},
           {0, 0, z / 2},
           {1, 0, 0},
           {0, 1, 0}},
          {"section",
           fmt::format("Upright section from G to A, x = {:g} mm", x / 2),
           "y, mm",
           "z, mm",
           {0, y},
           {0, z},
           {x / 2, 0, 0},
           {0, 1, 0},
           {0, 0, 1}}};
}

/// Returns true for the block and all parts on it. The cabinet, its parts and the centre are much colder and would
/// occupy most of the colour scale, so the image shows only their outlines.
bool is_drawn(thermal::GyroPart part) {
  return is_glass(part) || is_gas(part) || part == thermal::GyroPart::ballast_left ||
         part == thermal::GyroPart::ballast_right || part == thermal::GyroPart::cathode;
}

plot::ThermalImage sample_plane(const Plane& plane, const thermal::ThermalField& field, std::size_t columns) {
  const double per_mm = static_cast<double>(columns) / (plane.right_mm.high - plane.right_mm.low);
  const auto rows = static_cast<std::size_t>(std::lround((plane.up_mm.high - plane.up_mm.low) * per_mm));
  plot::ThermalImage image{.title = plane.title,
                           .x_title = plane.x_title,
                           .y_title = plane.y_title,
                           .x_mm = plane.right_mm,
                           .y_mm = plane.up_mm,
                           .celsius = {columns, rows, {}},
                           .parts = {},
                           .colours_c = {},
                           .marks = {},
                           .simulated = true};
  for (std::size_t row = 0; row < rows; ++row) {
    const double up = plane.up_mm.high - (static_cast<double>(row) + 0.5) / per_mm;
    for (std::size_t column = 0; column < columns; ++column) {
      const auto at = plane.point_m(plane.right_mm.low + (static_cast<double>(column) + 0.5) / per_mm, up);
      const auto part = field.part_at(at[0], at[1], at[2]);
      const bool is_coloured = part && is_drawn(*part);
      image.celsius.values.push_back(is_coloured ? field.temperature_at(at[0], at[1], at[2])
                                                 : std::numeric_limits<double>::quiet_NaN());
      image.parts.push_back(part && !is_air(*part) ? static_cast<int>(index(*part) + 1) : 0);
    }
  }
  return image;
}

std::vector<plot::ThermalMark> thermometer_marks(const thermal::GyroModel& model, const thermal::SteadyState& state) {
  std::vector<plot::ThermalMark> marks;
  for (std::size_t k = 0; k < model.thermometers.size(); ++k) {
    const auto [u, v] = model.thermometers[k];
    marks.push_back({std::string(thermal::kThermalOutputNames[k]), model.geometry.cabinet[0] / 2 + u,
                     model.geometry.cabinet[1] / 2 + v, state.outputs_c[k]});
  }
  return marks;
}

/// Crops a horizontal plane to the drawn parts that it intersects, plus a margin, rounded outwards to whole
/// millimetres.
void crop_to_block(Plane& plane, const thermal::GyroParts& parts) {
  thermal::PlanRectangle all = bounds(parts.block.plan);
  const auto add = [&](const thermal::Prism& prism) {
    const bool is_intersected = prism.z0 <= plane.origin_mm[2] && plane.origin_mm[2] <= prism.z1;
    if (!is_drawn(prism.part) || prism.plan.empty() || !is_intersected) return;
    const thermal::PlanRectangle one = bounds(prism.plan);
    all = {std::min(all.x0, one.x0), std::max(all.x1, one.x1), std::min(all.y0, one.y0), std::max(all.y1, one.y1)};
  };
  std::ranges::for_each(parts.boxes, add);
  std::ranges::for_each(parts.mirrors, add);
  plane.right_mm = {std::floor(all.x0 - kMargin_mm), std::ceil(all.x1 + kMargin_mm)};
  plane.up_mm = {std::floor(all.y0 - kMargin_mm), std::ceil(all.y1 + kMargin_mm)};
}

}  // namespace

std::vector<ThermalView> make_views(const thermal::GyroModel& model, const thermal::GyroMesh& mesh,
                                    const thermal::SteadyState& state, std::size_t columns) {
  const thermal::ThermalField field(model, mesh, state.field_c);
  std::vector<ThermalView> views;
  plot::Range colours{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const auto& plane : view_planes(model.geometry)) {
    views.push_back({plane.file, sample_plane(plane, field, columns)});
    colours = join_ranges(colours, plot::value_range(views.back().image.celsius.values));
  }
  views.front().image.marks = thermometer_marks(model, state);
  for (auto& view : views) view.image.colours_c = round_out(colours, 10);
  return views;
}

plot::ThermalImage make_top_face(const thermal::GyroModel& model, const thermal::GyroMesh& mesh,
                                 const thermal::SteadyState& state, std::size_t columns) {
  Plane plane = top_face(model.geometry);
  crop_to_block(plane, make_parts(model));
  auto image = sample_plane(plane, thermal::ThermalField(model, mesh, state.field_c), columns);
  image.marks = thermometer_marks(model, state);
  image.colours_c = round_out(plot::value_range(image.celsius.values), 10);
  return image;
}

}  // namespace gyrotherm::app
