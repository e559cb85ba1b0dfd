// SPDX-License-Identifier: Apache-2.0
/// The shapes of a gyro's parts. Each is a box or an upright convex prism.
#pragma once

#include <optional>
#include <vector>

#include "simulator/thermal/gyro_model.hpp"

namespace gyrotherm::thermal {

struct PlanPoint {
  double x{}, y{};
};

/// Convex, counter-clockwise outline. May be empty.
using Outline = std::vector<PlanPoint>;

struct PlanRectangle {
  double x0{}, x1{}, y0{}, y1{};
};

[[nodiscard]] double area(const Outline& outline);
[[nodiscard]] Outline to_outline(const PlanRectangle& rectangle);
/// Returns a regular polygon of 256 sides with the area of the circle.
[[nodiscard]] Outline circle(PlanPoint centre, double radius);
/// Returns the intersection of two convex outlines (Sutherland and Hodgman, Comm. ACM 17, 1974, 32).
[[nodiscard]] Outline intersection(const Outline& a, const Outline& b);
/// Returns the smallest axis-aligned rectangle around a non-empty outline.
[[nodiscard]] PlanRectangle bounds(const Outline& outline);
[[nodiscard]] bool contains(const Outline& outline, PlanPoint point);

/// An upright prism, mm, in the cabinet's axes.
struct Prism {
  GyroPart part{};
  Outline plan;
  double z0{}, z1{};
};

struct GyroParts {
  /// Parts with upright or level faces along the axes. Grid lines lie on their faces. The bores are inside block and
  /// mirrors and take precedence; no other two boxes overlap.
  std::vector<Prism> boxes;
  /// The whole block: hole and bores are not removed.
  Prism block;
  std::vector<Prism> mirrors;
  /// Through the block's thickness.
  Prism hole;
  /// Dither zone. It overlaps the hub; a point in both belongs to the hub.
  Prism dither;
  Prism hub;
  /// Plan of the cavity inside the cabinet's walls.
  PlanRectangle inside;
  double inside_z0{}, inside_z1{};
};

/// Returns all parts in the model's mode. Block mode has no preamplifier, dither, hub and cabinet, but uses the same
/// axes.
[[nodiscard]] GyroParts make_parts(const GyroModel& model);

/// Returns the part at a point in mm, or nothing outside all parts.
[[nodiscard]] std::optional<GyroPart> part_at(const GyroModel& model, const GyroParts& parts, double x, double y,
                                              double z);

/// Returns the gap that contains this height.
[[nodiscard]] GyroPart air_at(const GyroModel& model, double z);

}  // namespace gyrotherm::thermal
