// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/gyro_parts.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace gyrotherm::thermal {
namespace {

/// Returns twice the signed area of a, b, p: above 0 if p is left of the line from a to b.
double doubled_area(PlanPoint a, PlanPoint b, PlanPoint p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// Returns the part of an outline left of the line from a to b.
Outline cut(const Outline& outline, PlanPoint a, PlanPoint b) {
  Outline kept;
  kept.reserve(outline.size() + 1);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto from = outline[i];
    const auto to = outline[(i + 1) % outline.size()];
    const double from_side = doubled_area(a, b, from);
    const double to_side = doubled_area(a, b, to);
    if (from_side >= 0) kept.push_back(from);
    if ((from_side > 0 && to_side < 0) || (from_side < 0 && to_side > 0)) {
      const double t = from_side / (from_side - to_side);
      kept.push_back({from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)});
    }
  }
  return kept.size() < 3 ? Outline{} : kept;
}

struct Centre {
  double x, y, z;
};

Centre cabinet_centre(const GyroGeometry& g) { return {g.cabinet[0] / 2, g.cabinet[1] / 2, g.cabinet[2] / 2}; }

/// Returns the box with these offsets from the centre.
Prism box(GyroPart part, const Centre& c, PlanRectangle uv, double w0, double w1) {
  return {part, to_outline({c.x + uv.x0, c.x + uv.x1, c.y + uv.y0, c.y + uv.y1}), c.z + w0, c.z + w1};
}

/// Returns the square around a centre with its corners cut at |u| + |v| = `chamfer`.
Outline octagon(const Centre& c, double half, double chamfer) {
  const double cut = std::min(half, chamfer - half);
  return {{c.x + half, c.y - cut}, {c.x + half, c.y + cut}, {c.x + cut, c.y + half}, {c.x - cut, c.y + half},
          {c.x - half, c.y + cut}, {c.x - half, c.y - cut}, {c.x - cut, c.y - half}, {c.x + cut, c.y - half}};
}

/// Returns the plate on the 45° face towards (sign_x, sign_y).
Prism mirror(GyroPart part, const GyroGeometry& g, double sign_x, double sign_y) {
  const auto c = cabinet_centre(g);
  const double near = g.block_chamfer / std::numbers::sqrt2;
  const double far = near + g.mirror_thickness;
  const double half = g.mirror_width / 2;
  const auto at = [&](double along, double across) {
    return PlanPoint{c.x + sign_x * (along + across) / std::numbers::sqrt2,
                     c.y + sign_y * (along - across) / std::numbers::sqrt2};
  };
  Outline plan{at(near, half), at(far, half), at(far, -half), at(near, -half)};
  if (area(plan) < 0) plan = {plan[3], plan[2], plan[1], plan[0]};
  return {part, plan, c.z - g.mirror_height / 2, c.z + g.mirror_height / 2};
}

/// Adds the bores. Each gain arm is half the top side, corner included, and the upper half of a lateral side; the other
/// bores are passive.
void add_bores(const GyroGeometry& g, std::vector<Prism>& boxes) {
  const auto c = cabinet_centre(g);
  const double b = bore_half_width(g);
  const double near = g.ring_side / 2 - b;
  const double far = g.ring_side / 2 + b;
  const auto add = [&](GyroPart part, PlanRectangle uv) { boxes.push_back(box(part, c, uv, -b, b)); };
  add(GyroPart::gain_left, {-far, 0, near, far});
  add(GyroPart::gain_left, {-far, -near, 0, near});
  add(GyroPart::gain_right, {0, far, near, far});
  add(GyroPart::gain_right, {near, far, 0, near});
  add(GyroPart::passive_bore, {-far, 0, -far, -near});
  add(GyroPart::passive_bore, {-far, -near, -near, 0});
  add(GyroPart::passive_bore, {0, far, -far, -near});
  add(GyroPart::passive_bore, {near, far, -near, 0});
}

Prism preamplifier(const GyroGeometry& g) {
  const auto [length, width, thickness] = g.preamplifier;
  const auto c = cabinet_centre(g);
  if (g.preamplifier_mount == PreamplifierMount::wall) {
    const double v0 = g.wall - c.y;
    return box(GyroPart::preamplifier, c, {-length / 2, length / 2, v0, v0 + thickness}, -width / 2, width / 2);
  }
  if (g.preamplifier_mount == PreamplifierMount::lid) {
    const double w1 = c.z - g.wall;
    return box(GyroPart::preamplifier, c, {-width / 2, width / 2, -length / 2, length / 2}, w1 - thickness, w1);
  }
  constexpr double kHubClearance = 2;  // mm
  const double v1 = -g.hub_diameter / 2 - kHubClearance;
  const double w0 = g.wall - c.z;
  return box(GyroPart::preamplifier, c, {-length / 2, length / 2, v1 - width, v1}, w0, w0 + thickness);
}

}  // namespace

double area(const Outline& outline) {
  double twice = 0;
  for (std::size_t i = 2; i < outline.size(); ++i) twice += doubled_area(outline[0], outline[i - 1], outline[i]);
  return twice / 2;
}

Outline to_outline(const PlanRectangle& r) { return {{r.x0, r.y0}, {r.x1, r.y0}, {r.x1, r.y1}, {r.x0, r.y1}}; }

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
    if (doubled_area(outline[i], outline[(i + 1) % outline.size()], point) < 0) return false;
  }
  return !outline.empty();
}

GyroParts make_parts(const GyroModel& model) {
  const auto& g = model.geometry;
  const auto c = cabinet_centre(g);
  const double half = g.block_width / 2;
  const double thick = g.block_thickness / 2;
  GyroParts parts;
  add_bores(g, parts.boxes);
  const double side = ballast_side(g);
  const double low = g.ballast_top - side;
  parts.boxes.push_back(box(GyroPart::ballast_left, c, {-half - side, -half, low, g.ballast_top}, -side / 2, side / 2));
  parts.boxes.push_back(box(GyroPart::ballast_right, c, {half, half + side, low, g.ballast_top}, -side / 2, side / 2));
  parts.boxes.push_back(box(GyroPart::cathode, c, {-g.cathode[0] / 2, g.cathode[0] / 2, half, half + g.cathode[1]},
                            -g.cathode[2] / 2, g.cathode[2] / 2));
  if (model.mode == GyroMode::full) parts.boxes.push_back(preamplifier(g));
  parts.block = {GyroPart::block, octagon(c, half, g.block_chamfer), c.z - thick, c.z + thick};
  parts.mirrors = {mirror(GyroPart::mirror_b, g, -1, 1), mirror(GyroPart::mirror_c, g, 1, 1),
                   mirror(GyroPart::mirror_f, g, -1, -1), mirror(GyroPart::mirror_h, g, 1, -1)};
  const auto hole = circle({c.x, c.y}, g.hole_diameter / 2);
  parts.hole = {GyroPart::air_side, hole, c.z - thick, c.z + thick};
  parts.dither = {GyroPart::dither, hole, c.z - g.dither_height / 2, c.z + g.dither_height / 2};
  parts.hub = {GyroPart::hub, circle({c.x, c.y}, g.hub_diameter / 2), g.wall, c.z + g.hub_top};
  parts.inside = {g.wall, g.cabinet[0] - g.wall, g.wall, g.cabinet[1] - g.wall};
  parts.inside_z0 = g.wall;
  parts.inside_z1 = g.cabinet[2] - g.wall;
  return parts;
}

GyroPart air_at(const GyroModel& model, double z) {
  const double w = z - model.geometry.cabinet[2] / 2;
  if (std::abs(w) <= model.geometry.block_thickness / 2) return GyroPart::air_side;
  return w > 0 ? GyroPart::air_lid : GyroPart::air_base;
}

std::optional<GyroPart> part_at(const GyroModel& model, const GyroParts& parts, double x, double y, double z) {
  const bool full = model.mode == GyroMode::full;
  const auto in = [&](const Prism& prism) { return z >= prism.z0 && z <= prism.z1 && contains(prism.plan, {x, y}); };
  if (full) {
    const auto& c = model.geometry.cabinet;
    if (x < 0 || y < 0 || z < 0 || x > c[0] || y > c[1] || z > c[2]) return {};
    const auto& i = parts.inside;
    if (x < i.x0 || x > i.x1 || y < i.y0 || y > i.y1 || z < parts.inside_z0 || z > parts.inside_z1)
      return GyroPart::shell;
  }
  for (const auto& prism : parts.boxes)
    if (in(prism)) return prism.part;
  if (full && in(parts.hub)) return GyroPart::hub;
  if (full && in(parts.dither)) return GyroPart::dither;
  if (in(parts.block) && !in(parts.hole)) return GyroPart::block;
  for (const auto& prism : parts.mirrors)
    if (in(prism)) return prism.part;
  if (!full) return {};
  return air_at(model, z);
}

}  // namespace gyrotherm::thermal
