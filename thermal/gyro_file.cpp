#include "thermal/gyro_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/toml_reader.hpp"
#include "thermal/gyro_checks.hpp"

namespace gyrotherm {
namespace {

constexpr double kLargest = 1e12;  // in any unit of the file: what is beyond it is not meant

double positive(const TomlTable& table, std::string_view key) {
  const double value = table.number(key);
  if (!table.has(key) || (value > 0 && value < kLargest)) return value;
  table.mistake(key, fmt::format("{} is not above 0", value));
  return 0;
}

double between(const TomlTable& table, std::string_view key, double low, double high) {
  const double value = table.number(key);
  if (!table.has(key) || (value >= low && value <= high)) return value;
  table.mistake(key, fmt::format("{}, expected {} to {}", value, low, high));
  return low;
}

template <std::size_t N>
std::array<double, N> numbers(const TomlTable& table, std::string_view key, bool above_zero) {
  std::array<double, N> found{};
  const auto values = table.numbers(key);
  if (values.size() != N) {
    table.mistake(key, fmt::format("{} numbers, expected {}", values.size(), N));
    return found;
  }
  std::ranges::copy(values, found.begin());
  for (const double value : values)
    if (!(std::abs(value) < kLargest) || (above_zero && !(value > 0)))
      table.mistake(key, fmt::format("{}{}", value, above_zero ? " is not above 0" : " is not a place"));
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
  g.ballast_top = between(ballasts, "top_v_mm", -kLargest, kLargest);
  g.cathode = numbers<3>(root.table("cathode"), "size_mm", true);
  const auto preamplifier = root.table("preamplifier");
  g.preamplifier_place = static_cast<PreamplifierPlace>(one_of(preamplifier, "place", kPreamplifierPlaceNames));
  g.preamplifier = numbers<3>(preamplifier, "size_mm", true);
  g.dither_height = positive(root.table("dither"), "height_mm");
  const auto hub = root.table("hub");
  g.hub_diameter = positive(hub, "diameter_mm");
  g.hub_top = between(hub, "top_w_mm", -kLargest, kLargest);
  const auto cabinet = root.table("cabinet");
  g.cabinet = numbers<3>(cabinet, "size_mm", true);
  g.wall = positive(cabinet, "wall_mm");
  return g;
}

void read_materials(const TomlTable& root, GyroModel& model) {
  const auto materials = root.table("materials");
  for (std::size_t m = 0; m < kGyroMaterials; ++m) {
    const auto table = materials.table(kGyroMaterialNames[m]);
    if (!materials.has(kGyroMaterialNames[m])) materials.mistake(kGyroMaterialNames[m], "missing table");
    auto& material = model.materials[m];
    material.density_kg_per_m3 = positive(table, "density_kg_per_m3");
    material.specific_heat_j_per_kg_k = positive(table, "specific_heat_j_per_kg_k");
    if (static_cast<GyroMaterial>(m) != GyroMaterial::air)
      material.conductivity_w_per_m_k = positive(table, "conductivity_w_per_m_k");
  }
}

/// Watts of a source; where the file gives its rate too, rate × volume must agree within 1 %.
double power_w(const TomlTable& source, double volume_mm3) {
  const double power = between(source, "power_w", 0, kLargest);
  if (!source.has("rate_w_per_m3")) return power;
  const double by_rate = positive(source, "rate_w_per_m3") * volume_mm3 * 1e-9;
  if (std::abs(by_rate - power) > 0.01 * power) {
    source.mistake("power_w", fmt::format("{} W, but rate x volume is {:.4g} W", power, by_rate));
  }
  return power;
}

double ballast_power_w(const TomlTable& source, BallastReading reading, double volume_mm3) {
  const double printed = between(source, "printed_power_w", 0, kLargest);
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
  const double left = gain.has("left_share") ? between(gain, "left_share", 0, 1) : 0.5;
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
    return AirGap{between(table, "nusselt", 0.1, 100), between(table, "emissivity", 0, 1), 0};
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
  check_geometry(*root, model);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return model;
}

}  // namespace gyrotherm
