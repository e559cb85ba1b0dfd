/// The air in the cabinet's gaps: conduction, weak convection and radiation as one conductivity.
#pragma once

#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

/// One gap, between the block (or what stands on it) and the cabinet's wall.
struct AirGap {
  double nusselt = 1;   ///< heat carried over heat conducted
  double emissivity{};  ///< effective, of the two faces
  double width_m{};
};

struct CabinetAir {
  AirGap lid;
  AirGap side;
  AirGap base;
};

/// Thermal conductivity of dry air at 1 bar, W/(m·K), −60…150 °C, by Sutherland's law.
[[nodiscard]] double air_conductivity(double air_c);

/// k_eff = k_air(T)·Nu + 4 σ ε T³·width, W/(m·K), radiation linearised at T.
[[nodiscard]] double effective_conductivity(const AirGap& gap, double air_c);

/// The three gaps at `air_c`, and the outside's film as given.
[[nodiscard]] ThermalCoefficients coefficients_at(const CabinetAir& air, double air_c, double film_w_per_m2_k);

}  // namespace gyrotherm
