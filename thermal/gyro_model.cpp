#include "thermal/gyro_model.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm {

GyroMaterial material_of(GyroPart part) {
  using enum GyroPart;
  switch (part) {
    case block:
    case mirror_b:
    case mirror_c:
    case mirror_f:
    case mirror_h: return GyroMaterial::zerodur;
    case gain_left:
    case gain_right: return GyroMaterial::gain_gas;
    case passive_bore: return GyroMaterial::passive_bore;
    case ballast_left:
    case ballast_right: return GyroMaterial::ballast;
    case preamplifier: return GyroMaterial::preamplifier;
    case cathode: return GyroMaterial::cathode;
    case dither: return GyroMaterial::dither;
    case hub: return GyroMaterial::hub;
    case shell: return GyroMaterial::cabinet;
    case air_lid:
    case air_side:
    case air_base: break;
  }
  return GyroMaterial::air;
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

}  // namespace gyrotherm
