#include "thermal/plan_shapes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace gyrotherm {
namespace {

/// Twice the signed area of a, b, p: above 0 if p is left of the way from a to b.
double left_of(PlanPoint a, PlanPoint b, PlanPoint p) { return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x); }

/// The part of an outline left of the line from a to b.
Outline cut(const Outline& outline, PlanPoint a, PlanPoint b) {
  Outline kept;
  kept.reserve(outline.size() + 1);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto from = outline[i];
    const auto to = outline[(i + 1) % outline.size()];
    const double from_side = left_of(a, b, from);
    const double to_side = left_of(a, b, to);
    if (from_side >= 0) kept.push_back(from);
    if ((from_side > 0 && to_side < 0) || (from_side < 0 && to_side > 0)) {
      const double t = from_side / (from_side - to_side);
      kept.push_back({from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)});
    }
  }
  return kept.size() < 3 ? Outline{} : kept;
}

}  // namespace

double area(const Outline& outline) {
  double twice = 0;
  for (std::size_t i = 2; i < outline.size(); ++i) twice += left_of(outline[0], outline[i - 1], outline[i]);
  return twice / 2;
}

Outline outline_of(const PlanRectangle& r) { return {{r.x0, r.y0}, {r.x1, r.y0}, {r.x1, r.y1}, {r.x0, r.y1}}; }

Outline circle(PlanPoint centre, double radius) {
  constexpr int kSides = 256;
  constexpr double kStep = 2 * std::numbers::pi / kSides;
  const double corner = radius * std::sqrt(kStep / std::sin(kStep));
  Outline outline;
  for (int i = 0; i < kSides; ++i) {
    const double angle = (i + 0.5) * kStep;
    outline.push_back({centre.x + corner * std::cos(angle), centre.y + corner * std::sin(angle)});
  }
  return outline;
}

Outline intersection(const Outline& a, const Outline& b) {
  Outline common = a;
  for (std::size_t i = 0; i < b.size() && !common.empty(); ++i) common = cut(common, b[i], b[(i + 1) % b.size()]);
  return b.empty() ? Outline{} : common;
}

PlanRectangle bounds(const Outline& outline) {
  assert(!outline.empty());
  const auto [left, right] = std::ranges::minmax(outline, {}, &PlanPoint::x);
  const auto [low, high] = std::ranges::minmax(outline, {}, &PlanPoint::y);
  return {left.x, right.x, low.y, high.y};
}

bool contains(const Outline& outline, PlanPoint point) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if (left_of(outline[i], outline[(i + 1) % outline.size()], point) < 0) return false;
  }
  return !outline.empty();
}

}  // namespace gyrotherm
