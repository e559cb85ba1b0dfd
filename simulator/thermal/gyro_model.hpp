// SPDX-License-Identifier: Apache-2.0
/// A ring laser gyro in its cabinet as a thermal body: the content of a gyro file. Lengths are in millimetres only here
/// and in gyro_parts.hpp; all later steps use SI units. Axes: x to the right, y towards the cathode, z up through the
/// lid, origin at the lower corner of the cabinet; u, v, w are offsets from the common centre of block and cabinet.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// Part to which a point belongs. Left is the side of x below the centre.
enum class GyroPart : std::uint8_t {
  block,
  mirror_b,
  mirror_c,
  mirror_f,
  mirror_h,
  gain_left,
  gain_right,
  passive_bore,
  ballast_left,
  ballast_right,
  preamplifier,
  cathode,
  dither,
  hub,
  shell,
  air_lid,
  air_side,
  air_base
};
inline constexpr std::size_t kGyroParts = 18;
inline constexpr std::array<std::string_view, kGyroParts> kGyroPartNames{
    "block",      "mirror_b",     "mirror_c",     "mirror_f",      "mirror_h",     "gain_left",
    "gain_right", "passive_bore", "ballast_left", "ballast_right", "preamplifier", "cathode",
    "dither",     "hub",          "shell",        "air_lid",       "air_side",     "air_base"};
[[nodiscard]] constexpr std::size_t index(GyroPart part) { return static_cast<std::size_t>(part); }
[[nodiscard]] constexpr bool is_air(GyroPart part) { return part >= GyroPart::air_lid; }
[[nodiscard]] constexpr bool is_gas(GyroPart part) {
  return part >= GyroPart::gain_left && part <= GyroPart::passive_bore;
}
/// Returns whether a part is the block's Zerodur or a mirror on it.
[[nodiscard]] constexpr bool is_glass(GyroPart part) { return part <= GyroPart::mirror_h; }

enum class GyroMaterial : std::uint8_t {
  zerodur,
  gain_gas,
  passive_bore,
  ballast,
  preamplifier,
  cathode,
  dither,
  hub,
  cabinet,
  air
};
inline constexpr std::size_t kGyroMaterials = 10;
inline constexpr std::array<std::string_view, kGyroMaterials> kGyroMaterialNames{
    "zerodur", "gain_gas", "passive_bore", "ballast", "preamplifier", "cathode", "dither", "hub", "cabinet", "air"};
[[nodiscard]] GyroMaterial part_material(GyroPart part);

struct MaterialProperties {
  double density_kg_per_m3{};
  double specific_heat_j_per_kg_k{};
  /// 0 for air: the gaps have their own conductivity (thermal_system.hpp).
  double conductivity_w_per_m_k{};
};

/// Mounting of the preamplifier: upright on the wall at G, under the lid, or on the base next to the hub on the side of
/// G.
enum class PreamplifierMount { wall, lid, base };
inline constexpr std::array<std::string_view, 3> kPreamplifierMountNames{"wall", "lid", "base"};

/// Geometry in mm and mm³.
struct GyroGeometry {
  /// Twice the largest |u| and |v|.
  double block_width = 110;
  /// Largest |u| + |v|: the 45° faces.
  double block_chamfer = 80;
  double block_thickness = 25;
  double hole_diameter = 60;
  double mirror_width = 24;
  double mirror_height = 24;
  double mirror_thickness = 6;
  /// The bores run through (±half, ±half).
  double ring_side = 80;
  /// Volume of both gain arms together. Each arm is half the top and half a lateral side of the ring.
  double gain_volume = 1126;
  /// Volume of each ballast, which is a cube, and v of its upper side.
  double ballast_volume = 295;
  double ballast_top = -12;
  /// Sizes along x, out of the block, and along z.
  std::array<double, 3> cathode{20, 16, 20};
  PreamplifierMount preamplifier_mount = PreamplifierMount::wall;
  /// Length, width, and thickness perpendicular to its mounting face.
  std::array<double, 3> preamplifier{70, 50, 10};
  double dither_height = 30;
  double hub_diameter = 20;
  /// w of the hub's upper end. The lower end is on the base.
  double hub_top = 15;
  std::array<double, 3> cabinet{150, 150, 80};
  double wall = 3;
};

/// Returns half the side of the square bore of the gain volume, mm.
[[nodiscard]] double bore_half_width(const GyroGeometry& geometry);
/// Returns the side of a ballast, mm.
[[nodiscard]] double ballast_side(const GyroGeometry& geometry);

/// Interpretation of the contradictory row for the ballast resistors in the paper's Table 2.
enum class BallastReading { rate_times_volume, printed_each, printed_both, none };
inline constexpr std::array<std::string_view, 4> kBallastReadingNames{"rate x volume", "printed, each",
                                                                      "printed, both together", "none"};

/// Extent of the model: the gyro in its cabinet, or only its block in a film.
enum class GyroMode { full, block };
inline constexpr std::array<std::string_view, 2> kGyroModeNames{"full", "block"};

struct GyroModel {
  std::string name;
  std::string title;
  GyroMode mode = GyroMode::full;
  GyroGeometry geometry;
  std::array<MaterialProperties, kGyroMaterials> materials{};
  BallastReading ballast_reading = BallastReading::rate_times_volume;
  /// Powers of a switched-on gyro.
  ThermalPowers powers_w{};
  CabinetAir air;
  /// Film coefficients on the cabinet in free convection on a bench and under the chamber's fan, and on the block in
  /// block mode.
  double still_film_w_per_m2_k{};
  double chamber_film_w_per_m2_k{};
  double block_film_w_per_m2_k{};
  /// (u, v) of A…H on the block's top face, mm.
  std::array<std::array<double, 2>, 8> thermometers{};
};

/// Computes the widths of the model's air gaps from its geometry.
void set_gap_widths(GyroModel& model);

// Reads a gyro file (profiles/gyros/*.toml, schema "gyrotherm-gyro/1").

/// Reads a model. Fails with bad_file and reports every error with its position: sizes that are not above zero, parts
/// that overlap or leave the cabinet, a thermometer outside the block, powers that contradict rate × volume.
[[nodiscard]] Result<GyroModel> parse_gyro(std::string_view text, const std::string& file);

}  // namespace gyrotherm::thermal
