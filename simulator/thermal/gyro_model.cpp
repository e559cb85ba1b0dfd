// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/gyro_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/toml_reader.hpp"
#include "simulator/thermal/gyro_parts.hpp"

namespace gyrotherm::thermal {

GyroMaterial part_material(GyroPart part) {
  using enum GyroMaterial;
  constexpr std::array<GyroMaterial, kGyroParts> kPartMaterials{{zerodur, zerodur, zerodur, zerodur, zerodur, gain_gas,
                                                                 gain_gas, passive_bore, ballast, ballast, preamplifier,
                                                                 cathode, dither, hub, cabinet, air, air, air}};
  return kPartMaterials[index(part)];
}

double bore_half_width(const GyroGeometry& geometry) {
  return std::sqrt(geometry.gain_volume / (2 * geometry.ring_side)) / 2;
}

double ballast_side(const GyroGeometry& geometry) { return std::cbrt(geometry.ballast_volume); }

void set_gap_widths(GyroModel& model) {
  const auto& g = model.geometry;
  model.air.lid.width_m = model.air.base.width_m = 1e-3 * ((g.cabinet[2] - g.block_thickness) / 2 - g.wall);
  model.air.side.width_m = 1e-3 * ((std::min(g.cabinet[0], g.cabinet[1]) - g.block_width) / 2 - g.wall);
}

namespace {

constexpr double kTouchTolerance = 1e-6;  // mm
// Limit of the cabinet's size, mm. The mesh of a larger cabinet would not fit into memory.
constexpr double kLargestCabinet = 500;

struct Solid {
  Prism prism;
  const char* table;
  const char* key;
};

const char* table_name(GyroPart part) {
  if (part == GyroPart::cathode) return "cathode";
  return part == GyroPart::preamplifier ? "preamplifier" : "ballasts";
}

std::vector<Solid> list_solids(const GyroParts& parts) {
  std::vector<Solid> solids{{parts.block, "block", "width_mm"}};
  for (const auto& mirror : parts.mirrors) solids.push_back({mirror, "mirrors", "thickness_mm"});
  for (const auto& box : parts.boxes) {
    if (is_gas(box.part)) continue;
    const bool ballast = box.part == GyroPart::ballast_left || box.part == GyroPart::ballast_right;
    solids.push_back({box, table_name(box.part), ballast ? "top_v_mm" : "size_mm"});
  }
  solids.push_back({parts.dither, "dither", "height_mm"});
  solids.push_back({parts.hub, "hub", "top_w_mm"});
  return solids;
}

/// Returns whether two parts may overlap. Dither zone and hub are inside the block's hole.
bool may_share_space(GyroPart a, GyroPart b) {
  const auto inner = [](GyroPart part) { return part == GyroPart::dither || part == GyroPart::hub; };
  return (inner(a) && inner(b)) || (inner(a) && b == GyroPart::block) || (inner(b) && a == GyroPart::block);
}

void check_space(const TomlTable& root, const GyroModel& model) {
  auto full = model;
  full.mode = GyroMode::full;
  const auto parts = make_parts(full);
  const auto solids = list_solids(parts);
  for (const auto& solid : solids) {
    const auto b = bounds(solid.prism.plan);
    const auto& in = parts.inside;
    if (b.x0 < in.x0 - kTouchTolerance || b.x1 > in.x1 + kTouchTolerance || b.y0 < in.y0 - kTouchTolerance ||
        b.y1 > in.y1 + kTouchTolerance || solid.prism.z0 < parts.inside_z0 - kTouchTolerance ||
        solid.prism.z1 > parts.inside_z1 + kTouchTolerance) {
      root.table(solid.table)
          .note_error(solid.key,
                      fmt::format("{} reaches outside the cabinet's walls", kGyroPartNames[index(solid.prism.part)]));
    }
  }
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto& a = solids[i].prism;
      const auto& b = solids[j].prism;
      const double height = std::min(a.z1, b.z1) - std::max(a.z0, b.z0);
      if (height < kTouchTolerance || may_share_space(a.part, b.part)) continue;
      if (const double shared = area(intersection(a.plan, b.plan)) * height; shared > 1e-3) {
        root.table(solids[i].table)
            .note_error(solids[i].key, fmt::format("{} overlaps {} by {:.3g} mm³", kGyroPartNames[index(a.part)],
                                                   kGyroPartNames[index(b.part)], shared));
      }
    }
  }
}

/// Checks the consistency of the shapes of block, bores and mirrors.
void check_block(const TomlTable& root, const GyroGeometry& g) {
  const auto expect = [&](bool law, const char* table, const char* key, const std::string& what) {
    if (!law) root.table(table).note_error(key, what);
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
         fmt::format("bores of {:.4g} mm, wider than the height of the mirrors", bore));
  expect(g.ring_side + bore < g.block_width, "bores", "ring_side_mm",
         fmt::format("{} mm, bores of {:.4g} mm extend outside the block", g.ring_side, bore));
  expect(g.ring_side + bore <= g.block_chamfer + g.mirror_thickness * std::numbers::sqrt2, "bores", "ring_side_mm",
         fmt::format("{} mm, the ring's corners are outside the mirrors", g.ring_side));
  expect(g.ring_side - bore > g.hole_diameter, "block", "hole_diameter_mm",
         fmt::format("{} mm, the hole reaches the bores", g.hole_diameter));
  expect(g.hub_diameter < g.hole_diameter, "hub", "diameter_mm",
         fmt::format("{} mm, not smaller than the hole", g.hub_diameter));
  expect(std::ranges::max(g.cabinet) <= kLargestCabinet, "cabinet", "size_mm",
         fmt::format("{:.6g} mm, expected at most {:g} mm", std::ranges::max(g.cabinet), kLargestCabinet));
  expect(g.cabinet[0] > 2 * g.wall && g.cabinet[1] > 2 * g.wall && g.cabinet[2] > 2 * g.wall, "cabinet", "wall_mm",
         fmt::format("{} mm, leaves no space inside", g.wall));
}

void check_thermometers(const TomlTable& root, const GyroModel& model) {
  const auto parts = make_parts(model);
  const auto& g = model.geometry;
  for (std::size_t t = 0; t < model.thermometers.size(); ++t) {
    const auto& [u, v] = model.thermometers[t];
    const PlanPoint point{g.cabinet[0] / 2 + u, g.cabinet[1] / 2 + v};
    if (!contains(parts.block.plan, point) || contains(parts.hole.plan, point)) {
      root.table("thermometers")
          .note_error(kThermalOutputNames[t], fmt::format("({}, {}) is not on the block's top face", u, v));
    }
  }
}

// Limit of each value, in the unit of the file.
constexpr double kLargest = 1e12;

double positive(const TomlTable& table, std::string_view key) {
  const double value = table.number(key);
  if (!table.has(key) || (value > 0 && value < kLargest)) return value;
  table.note_error(key, fmt::format("{} is not above 0", value));
  return 0;
}

double read_number_between(const TomlTable& table, std::string_view key, double low, double high) {
  const double value = table.number(key);
  if (!table.has(key) || (value >= low && value <= high)) return value;
  table.note_error(key, fmt::format("{}, expected {} to {}", value, low, high));
  return low;
}

template <std::size_t N>
std::array<double, N> numbers(const TomlTable& table, std::string_view key, bool above_zero) {
  std::array<double, N> found{};
  const auto values = table.numbers(key);
  if (values.size() != N) {
    table.note_error(key, fmt::format("{} numbers, expected {}", values.size(), N));
    return found;
  }
  std::ranges::copy(values, found.begin());
  for (const double value : values)
    if (!(std::abs(value) < kLargest) || (above_zero && !(value > 0)))
      table.note_error(key, fmt::format("{}{}", value, above_zero ? " is not above 0" : " is not a position"));
  return found;
}

template <std::size_t N>
std::size_t one_of(const TomlTable& table, std::string_view key, const std::array<std::string_view, N>& names) {
  const auto chosen = table.choice(key, {names.begin(), names.end()});
  const auto found = std::ranges::find(names, std::string_view(chosen));
  return found == names.end() ? 0 : static_cast<std::size_t>(found - names.begin());
}

GyroGeometry read_geometry(const TomlTable& root) {
  GyroGeometry g;
  const auto block = root.table("block");
  g.block_width = positive(block, "width_mm");
  g.block_chamfer = positive(block, "chamfer_mm");
  g.block_thickness = positive(block, "thickness_mm");
  g.hole_diameter = positive(block, "hole_diameter_mm");
  const auto mirrors = root.table("mirrors");
  g.mirror_width = positive(mirrors, "width_mm");
  g.mirror_height = positive(mirrors, "height_mm");
  g.mirror_thickness = positive(mirrors, "thickness_mm");
  const auto bores = root.table("bores");
  g.ring_side = positive(bores, "ring_side_mm");
  g.gain_volume = positive(bores, "gain_volume_mm3");
  const auto ballasts = root.table("ballasts");
  g.ballast_volume = positive(ballasts, "volume_mm3");
  g.ballast_top = read_number_between(ballasts, "top_v_mm", -kLargest, kLargest);
  g.cathode = numbers<3>(root.table("cathode"), "size_mm", true);
  const auto preamplifier = root.table("preamplifier");
  g.preamplifier_mount = static_cast<PreamplifierMount>(one_of(preamplifier, "place", kPreamplifierMountNames));
  g.preamplifier = numbers<3>(preamplifier, "size_mm", true);
  g.dither_height = positive(root.table("dither"), "height_mm");
  const auto hub = root.table("hub");
  g.hub_diameter = positive(hub, "diameter_mm");
  g.hub_top = read_number_between(hub, "top_w_mm", -kLargest, kLargest);
  const auto cabinet = root.table("cabinet");
  g.cabinet = numbers<3>(cabinet, "size_mm", true);
  g.wall = positive(cabinet, "wall_mm");
  return g;
}

void read_materials(const TomlTable& root, GyroModel& model) {
  const auto materials = root.table("materials");
  for (std::size_t m = 0; m < kGyroMaterials; ++m) {
    const auto table = materials.table(kGyroMaterialNames[m]);
    if (!materials.has(kGyroMaterialNames[m])) materials.note_error(kGyroMaterialNames[m], "missing table");
    auto& material = model.materials[m];
    material.density_kg_per_m3 = positive(table, "density_kg_per_m3");
    material.specific_heat_j_per_kg_k = positive(table, "specific_heat_j_per_kg_k");
    if (static_cast<GyroMaterial>(m) != GyroMaterial::air)
      material.conductivity_w_per_m_k = positive(table, "conductivity_w_per_m_k");
  }
}

/// Reads the power of a source, W. If the file also contains its rate, rate × volume must agree within 1 %.
double power_w(const TomlTable& source, double volume_mm3) {
  const double power = read_number_between(source, "power_w", 0, kLargest);
  if (!source.has("rate_w_per_m3")) return power;
  const double by_rate = positive(source, "rate_w_per_m3") * volume_mm3 * 1e-9;
  if (std::abs(by_rate - power) > 0.01 * power) {
    source.note_error("power_w", fmt::format("{} W, but rate x volume is {:.4g} W", power, by_rate));
  }
  return power;
}

double ballast_power_w(const TomlTable& source, BallastReading reading, double volume_mm3) {
  const double printed = read_number_between(source, "printed_power_w", 0, kLargest);
  const double by_rate = positive(source, "rate_w_per_m3") * volume_mm3 * 1e-9;
  switch (reading) {
    case BallastReading::rate_times_volume: return by_rate;
    case BallastReading::printed_each: return printed;
    case BallastReading::printed_both: return printed / 2;
    case BallastReading::none: break;
  }
  return 0;
}

void read_sources(const TomlTable& root, GyroModel& model) {
  const auto sources = root.table("sources");
  const auto gain = sources.table("gain_area");
  const double total = power_w(gain, model.geometry.gain_volume);
  const double left = gain.has("left_share") ? read_number_between(gain, "left_share", 0, 1) : 0.5;
  const auto& size = model.geometry.preamplifier;
  const double preamplifier = power_w(sources.table("preamplifier"), size[0] * size[1] * size[2]);
  const auto ballast = sources.table("ballast");
  model.ballast_reading = static_cast<BallastReading>(one_of(ballast, "reading", kBallastReadingNames));
  const double each = ballast_power_w(ballast, model.ballast_reading, model.geometry.ballast_volume);
  model.powers_w = {left * total, (1 - left) * total, preamplifier, each, each};
}

void read_air(const TomlTable& root, GyroModel& model) {
  const auto air = root.table("air");
  const auto gap = [&](const char* name) {
    const auto table = air.table(name);
    return AirGap{read_number_between(table, "nusselt", 0.1, 100), read_number_between(table, "emissivity", 0, 1), 0};
  };
  model.air = {gap("lid"), gap("side"), gap("base")};
  set_gap_widths(model);
  const auto film = root.table("film");
  model.still_film_w_per_m2_k = positive(film, "still_w_per_m2_k");
  model.chamber_film_w_per_m2_k = positive(film, "chamber_w_per_m2_k");
  model.block_film_w_per_m2_k = positive(film, "block_w_per_m2_k");
}

}  // namespace

Result<GyroModel> parse_gyro(std::string_view text, const std::string& file) {
  const auto root = TomlTable::parse(text, file);
  if (!root) return failure(root.error());
  root->expect("schema", "gyrotherm-gyro/1");
  GyroModel model;
  model.name = root->text("name");
  model.title = root->text("title");
  model.mode = static_cast<GyroMode>(one_of(*root, "mode", kGyroModeNames));
  model.geometry = read_geometry(*root);
  read_materials(*root, model);
  read_sources(*root, model);
  read_air(*root, model);
  const auto thermometers = root->table("thermometers");
  for (std::size_t t = 0; t < model.thermometers.size(); ++t)
    model.thermometers[t] = numbers<2>(thermometers, kThermalOutputNames[t], false);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  // All sizes are above zero here.
  check_block(*root, model.geometry);
  check_space(*root, model);
  check_thermometers(*root, model);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return model;
}

}  // namespace gyrotherm::thermal
