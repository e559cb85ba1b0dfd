#include "thermal/gyro_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "thermal/gyro_parts.hpp"

namespace gyrotherm {
namespace {

constexpr double kTouching = 1e-6;  // mm

struct Solid {
  Prism prism;
  const char* table;
  const char* key;
};

const char* table_of(GyroPart part) {
  if (part == GyroPart::cathode) return "cathode";
  return part == GyroPart::preamplifier ? "preamplifier" : "ballasts";
}

std::vector<Solid> solids_of(const GyroParts& parts) {
  std::vector<Solid> solids{{parts.block, "block", "width_mm"}};
  for (const auto& mirror : parts.mirrors) solids.push_back({mirror, "mirrors", "thickness_mm"});
  for (const auto& box : parts.boxes) {
    if (is_gas(box.part)) continue;
    const bool ballast = box.part == GyroPart::ballast_left || box.part == GyroPart::ballast_right;
    solids.push_back({box, table_of(box.part), ballast ? "top_v_mm" : "size_mm"});
  }
  solids.push_back({parts.dither, "dither", "height_mm"});
  solids.push_back({parts.hub, "hub", "top_w_mm"});
  return solids;
}

/// Dither zone and hub stand inside the block's hole.
bool may_share_space(GyroPart a, GyroPart b) {
  const auto inner = [](GyroPart part) { return part == GyroPart::dither || part == GyroPart::hub; };
  return (inner(a) && inner(b)) || (inner(a) && b == GyroPart::block) || (inner(b) && a == GyroPart::block);
}

void check_space(const TomlTable& root, const GyroModel& model) {
  auto full = model;
  full.mode = GyroMode::full;
  const auto parts = parts_of(full);
  const auto solids = solids_of(parts);
  for (const auto& solid : solids) {
    const auto b = bounds(solid.prism.plan);
    const auto& in = parts.inside;
    if (b.x0 < in.x0 - kTouching || b.x1 > in.x1 + kTouching || b.y0 < in.y0 - kTouching || b.y1 > in.y1 + kTouching ||
        solid.prism.z0 < parts.inside_z0 - kTouching || solid.prism.z1 > parts.inside_z1 + kTouching) {
      root.table(solid.table)
          .mistake(solid.key,
                   fmt::format("{} reaches outside the cabinet's walls", kGyroPartNames[index(solid.prism.part)]));
    }
  }
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto& a = solids[i].prism;
      const auto& b = solids[j].prism;
      const double height = std::min(a.z1, b.z1) - std::max(a.z0, b.z0);
      if (height < kTouching || may_share_space(a.part, b.part)) continue;
      if (const double shared = area(intersection(a.plan, b.plan)) * height; shared > 1e-3) {
        root.table(solids[i].table)
            .mistake(solids[i].key, fmt::format("{} overlaps {} by {:.3g} mm³", kGyroPartNames[index(a.part)],
                                                kGyroPartNames[index(b.part)], shared));
      }
    }
  }
}

/// What must hold for the block, its bores and mirrors to be the shape they are said to be.
void check_block(const TomlTable& root, const GyroGeometry& g) {
  const auto expect = [&](bool law, const char* table, const char* key, const std::string& what) {
    if (!law) root.table(table).mistake(key, what);
  };
  const double bore = 2 * bore_half_width(g);
  const double face = (g.block_width - g.block_chamfer) * std::numbers::sqrt2;
  expect(g.block_chamfer > g.block_width / 2 && g.block_chamfer < g.block_width, "block", "chamfer_mm",
         fmt::format("{} mm, expected between half the width and the width", g.block_chamfer));
  expect(g.mirror_width <= face, "mirrors", "width_mm",
         fmt::format("{} mm, wider than the block's 45° faces of {:.4g} mm", g.mirror_width, face));
  expect(g.mirror_height <= g.block_thickness, "mirrors", "height_mm",
         fmt::format("{} mm, more than the block's thickness of {} mm", g.mirror_height, g.block_thickness));
  expect(bore < g.mirror_height, "bores", "gain_volume_mm3",
         fmt::format("bores of {:.4g} mm, wider than the mirrors are high", bore));
  expect(g.ring_side + bore < g.block_width, "bores", "ring_side_mm",
         fmt::format("{} mm, bores of {:.4g} mm leave the block", g.ring_side, bore));
  expect(g.ring_side + bore <= g.block_chamfer + g.mirror_thickness * std::numbers::sqrt2, "bores", "ring_side_mm",
         fmt::format("{} mm, the corners leave the mirrors", g.ring_side));
  expect(g.ring_side - bore > g.hole_diameter, "block", "hole_diameter_mm",
         fmt::format("{} mm, reaches the bores", g.hole_diameter));
  expect(g.hub_diameter < g.hole_diameter, "hub", "diameter_mm",
         fmt::format("{} mm, not smaller than the hole", g.hub_diameter));
  expect(g.cabinet[0] > 2 * g.wall && g.cabinet[1] > 2 * g.wall && g.cabinet[2] > 2 * g.wall, "cabinet", "wall_mm",
         fmt::format("{} mm, leaves no space inside", g.wall));
}

void check_thermometers(const TomlTable& root, const GyroModel& model) {
  const auto parts = parts_of(model);
  const auto& g = model.geometry;
  for (std::size_t t = 0; t < model.thermometers.size(); ++t) {
    const auto& [u, v] = model.thermometers[t];
    const PlanPoint point{g.cabinet[0] / 2 + u, g.cabinet[1] / 2 + v};
    if (!contains(parts.block.plan, point) || contains(parts.hole.plan, point)) {
      root.table("thermometers")
          .mistake(kThermalOutputNames[t], fmt::format("({}, {}) is not on the block's top face", u, v));
    }
  }
}

}  // namespace

void check_geometry(const TomlTable& root, const GyroModel& model) {
  check_block(root, model.geometry);
  check_space(root, model);
  check_thermometers(root, model);
}

}  // namespace gyrotherm
