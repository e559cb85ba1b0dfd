// SPDX-License-Identifier: Apache-2.0
/// A gyro's parts in space: every one a box or an upright convex prism.
#pragma once

#include <optional>
#include <vector>

#include "simulator/thermal/gyro_model.hpp"

namespace gyrotherm::thermal {

struct PlanPoint {
  double x{}, y{};
};

/// Convex, counter-clockwise; empty: nothing.
using Outline = std::vector<PlanPoint>;

struct PlanRectangle {
  double x0{}, x1{}, y0{}, y1{};
};

[[nodiscard]] double area(const Outline& outline);
[[nodiscard]] Outline outline_of(const PlanRectangle& rectangle);
/// A regular polygon of 256 sides with the area of the circle.
[[nodiscard]] Outline circle(PlanPoint centre, double radius);
/// What two convex outlines share (Sutherland and Hodgman, Comm. ACM 17, 1974, 32).
[[nodiscard]] Outline intersection(const Outline& a, const Outline& b);
/// Smallest upright rectangle around it; the outline has points.
[[nodiscard]] PlanRectangle bounds(const Outline& outline);
[[nodiscard]] bool contains(const Outline& outline, PlanPoint point);

/// In mm, in the cabinet's axes.
struct Prism {
  GyroPart part{};
  Outline plan;
  double z0{}, z1{};
};

struct GyroParts {
  /// Parts whose sides are all upright or level planes along the axes: grid lines lie on their faces. The bores lie
  /// inside block and mirrors and take their place; no other two overlap.
  std::vector<Prism> boxes;
  Prism block;  ///< with neither hole nor bores taken out
  std::vector<Prism> mirrors;
  Prism hole;    ///< through the block's thickness
  Prism dither;  ///< with the hub inside it not taken out
  Prism hub;
  PlanRectangle inside;  ///< of the cabinet's walls
  double inside_z0{}, inside_z1{};
};

/// All parts of the model's mode: in block mode without preamplifier, dither, hub and cabinet, in the same axes.
[[nodiscard]] GyroParts parts_of(const GyroModel& model);

/// To which part a point in mm belongs; nothing outside of everything.
[[nodiscard]] std::optional<GyroPart> part_at(const GyroModel& model, const GyroParts& parts, double x, double y,
                                              double z);

/// Air of which gap, by height alone.
[[nodiscard]] GyroPart air_at(const GyroModel& model, double z);

}  // namespace gyrotherm::thermal
