#include "simulator/thermometer_bank.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm {

double to_resolution(double value, double resolution) {
  return resolution > 0 ? std::round(value / resolution) * resolution : value;
}

ThermometerBank::ThermometerBank(const ThermometerParameters& parameters, PlaceTemperatures places_c,
                                 std::uint64_t seed)
    : parameters_(parameters),
      follow_(parameters.time_constant_s > 0 ? -std::expm1(-1 / parameters.time_constant_s) : 1),
      noise_(seed, RandomPurpose::thermometer_noise) {
  std::ranges::copy(places_c, sensed_c_.begin());
  read();
}

void ThermometerBank::step(PlaceTemperatures places_c) {
  for (std::size_t i = 0; i < kThermalPlaces; ++i) sensed_c_[i] += follow_ * (places_c[i] - sensed_c_[i]);
  read();
}

void ThermometerBank::read() {
  for (std::size_t i = 0; i < kThermalPlaces; ++i) {
    const double shown_c = sensed_c_[i] + parameters_.offset_k[i] + parameters_.noise_k * noise_.normal();
    readings_c_[i] = to_resolution(shown_c, parameters_.resolution_k);
  }
}

}  // namespace gyrotherm
