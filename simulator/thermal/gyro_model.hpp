// SPDX-License-Identifier: Apache-2.0
/// A ring laser gyro in its cabinet as a thermal body: what a gyro file says, in numbers. Lengths in millimetres here
/// and in gyro_parts.hpp alone; everything after them is SI. Axes: x to the right, y towards the cathode, z up through
/// the lid, origin at the lower corner of the cabinet; u, v, w are offsets from the block's centre, which is the
/// cabinet's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::thermal {

/// What a piece of space belongs to. Left is the side of x below the centre.
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
/// The block's Zerodur and the mirrors on it.
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
[[nodiscard]] GyroMaterial material_of(GyroPart part);

struct MaterialProperties {
  double density_kg_per_m3{};
  double specific_heat_j_per_kg_k{};
  double conductivity_w_per_m_k{};  ///< of air: 0, its gaps have their own (thermal_system.hpp)
};

/// Upright on the wall at G; under the lid; on the base beside the hub, on the side of G.
enum class PreamplifierPlace { wall, lid, base };
inline constexpr std::array<std::string_view, 3> kPreamplifierPlaceNames{"wall", "lid", "base"};

/// In mm and mm³.
struct GyroGeometry {
  double block_width = 110;   ///< |u|, |v| up to half of it
  double block_chamfer = 80;  ///< |u| + |v| up to it: the 45° faces
  double block_thickness = 25;
  double hole_diameter = 60;
  double mirror_width = 24;
  double mirror_height = 24;
  double mirror_thickness = 6;
  double ring_side = 80;        ///< the bores run through (±half, ±half)
  double gain_volume = 1126;    ///< of both gain arms, each half the top and half a lateral side of the ring
  double ballast_volume = 295;  ///< of each, a cube
  double ballast_top = -12;     ///< v of its upper side
  std::array<double, 3> cathode{20, 16, 20};  ///< along x, out of the block, along z
  PreamplifierPlace preamplifier_place = PreamplifierPlace::wall;
  std::array<double, 3> preamplifier{70, 50, 10};  ///< length, width, and thickness off its wall
  double dither_height = 30;
  double hub_diameter = 20;
  double hub_top = 15;  ///< w of its upper end; the lower one stands on the base
  std::array<double, 3> cabinet{150, 150, 80};
  double wall = 3;
};

/// Half the side of the square bore of the gain volume, mm.
[[nodiscard]] double bore_half_width(const GyroGeometry& geometry);
/// Side of a ballast, mm.
[[nodiscard]] double ballast_side(const GyroGeometry& geometry);

/// How the table's contradictory row of the ballast resistors is understood.
enum class BallastReading { rate_times_volume, printed_each, printed_both, none };
inline constexpr std::array<std::string_view, 4> kBallastReadingNames{"rate x volume", "printed, each",
                                                                      "printed, both together", "none"};

enum class GyroMode { full, block };  ///< in its cabinet, or the block alone in a film
inline constexpr std::array<std::string_view, 2> kGyroModeNames{"full", "block"};

struct GyroModel {
  std::string name;
  std::string title;
  GyroMode mode = GyroMode::full;
  GyroGeometry geometry;
  std::array<MaterialProperties, kGyroMaterials> materials{};
  BallastReading ballast_reading = BallastReading::rate_times_volume;
  ThermalPowers powers_w{};  ///< gyro switched on
  CabinetAir air;
  double still_film_w_per_m2_k{};                       ///< on the cabinet, free convection on a bench
  double chamber_film_w_per_m2_k{};                     ///< on the cabinet, under the chamber's fan
  double block_film_w_per_m2_k{};                       ///< on the block when it stands alone
  std::array<std::array<double, 2>, 8> thermometers{};  ///< (u, v) of A…H on the block's top face, mm
};

/// Widths of the model's air gaps from its geometry.
void set_gap_widths(GyroModel& model);

// Reads a gyro file (profiles/gyros/*.toml, schema "gyrotherm-gyro/1").

/// Fails with bad_file, every mistake with its place: sizes that are not above zero, parts that overlap or leave the
/// cabinet, a thermometer off the block, powers that contradict rate × volume.
[[nodiscard]] Result<GyroModel> parse_gyro(std::string_view text, const std::string& file);

}  // namespace gyrotherm::thermal
