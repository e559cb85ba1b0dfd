// SPDX-License-Identifier: Apache-2.0
#include "core/humidity.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm {
namespace {

constexpr double kAtZeroHpa = 6.112;

/// Coefficients of the Magnus formula over one surface.
struct Magnus {
  double slope{};
  double offset_c{};
};
constexpr Magnus kWater{17.62, 243.12}, kIce{22.46, 272.62};

double saturation_hpa(const Magnus& over, Celsius temperature) {
  return kAtZeroHpa * std::exp(over.slope * temperature.value / (over.offset_c + temperature.value));
}

Celsius saturated_at(const Magnus& over, double vapour_hpa) {
  const double logarithm = std::log(vapour_hpa / kAtZeroHpa);
  return {over.offset_c * logarithm / (over.slope - logarithm)};
}

}  // namespace

double saturation_over_water_hpa(Celsius temperature) { return saturation_hpa(kWater, temperature); }
double saturation_over_ice_hpa(Celsius temperature) { return saturation_hpa(kIce, temperature); }

std::optional<Celsius> dew_point(Celsius air, double humidity_percent) {
  constexpr double kColdestC = -45, kWarmestC = 100, kMostPercent = 105;
  if (!(air.value >= kColdestC && air.value <= kWarmestC)) return std::nullopt;
  if (!(humidity_percent > 0 && humidity_percent <= kMostPercent)) return std::nullopt;
  return saturated_at(kWater, saturation_hpa(kWater, air) * std::min(humidity_percent, 100.0) / 100);
}

double relative_humidity_percent(Celsius air, Celsius dew_point) {
  return 100 * saturation_hpa(kWater, dew_point) / saturation_hpa(kWater, air);
}

Celsius dew_point_at(double vapour_hpa) { return saturated_at(kWater, vapour_hpa); }

Celsius saturation_temperature(double vapour_hpa) {
  return saturated_at(vapour_hpa < kAtZeroHpa ? kIce : kWater, vapour_hpa);
}

Celsius condensation_point(Celsius dew_point) { return saturation_temperature(saturation_hpa(kWater, dew_point)); }

}  // namespace gyrotherm
