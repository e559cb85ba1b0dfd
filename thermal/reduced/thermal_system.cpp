// SPDX-License-Identifier: Apache-2.0
#include "thermal/reduced/thermal_system.hpp"

#include <cmath>

#include "core/quantity.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr double kStefanBoltzmann = 5.670374419e-8;  // W/(m²·K⁴)

}  // namespace

double air_conductivity(double air_c) {
  constexpr double kAtZero = 0.0241;     // W/(m·K)
  constexpr double kSutherland = 194.0;  // K; F. M. White, Viscous Fluid Flow, 3rd ed., table 1-3
  const double t = (air_c + kZeroCelsiusInKelvin) / kZeroCelsiusInKelvin;
  return kAtZero * std::pow(t, 1.5) * (kZeroCelsiusInKelvin + kSutherland) /
         (air_c + kZeroCelsiusInKelvin + kSutherland);
}

double effective_conductivity(const AirGap& gap, double air_c) {
  const double t = air_c + kZeroCelsiusInKelvin;
  return air_conductivity(air_c) * gap.nusselt + 4 * kStefanBoltzmann * gap.emissivity * t * t * t * gap.width_m;
}

ThermalCoefficients coefficients_at(const CabinetAir& air, double air_c, double film_w_per_m2_k) {
  return {effective_conductivity(air.lid, air_c), effective_conductivity(air.side, air_c),
          effective_conductivity(air.base, air_c), film_w_per_m2_k};
}

}  // namespace gyrotherm::thermal
