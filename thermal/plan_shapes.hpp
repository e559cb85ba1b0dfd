/// Convex shapes in the plane of the block, and how much of one lies in another.
#pragma once

#include <vector>

namespace gyrotherm {

struct PlanPoint {
  double x{};
  double y{};
};

/// Convex, counter-clockwise; empty: nothing.
using Outline = std::vector<PlanPoint>;

struct PlanRectangle {
  double x0{};
  double x1{};
  double y0{};
  double y1{};
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

}  // namespace gyrotherm
