#include "simulator/thermometer_bank.hpp"

#include <algorithm>
#include <cmath>

namespace gyrotherm {
namespace {

static_assert(std::tuple_size_v<EachThermometer> == kThermalPlaces);
constexpr double kSecondsPerDay = 86400;
constexpr double kCalibratedAtC = 20;

}  // namespace

double to_resolution(double value, double resolution) {
  return resolution > 0 ? std::round(value / resolution) * resolution : value;
}

ThermometerBank::ThermometerBank(const ThermometerParameters& parameters, PlaceTemperatures places_c,
                                 std::uint64_t seed)
    : parameters_(parameters),
      noise_(seed, RandomPurpose::thermometer_noise),
      drift_noise_(seed, RandomPurpose::thermometer_drift) {
  const auto& p = parameters_;
  std::ranges::copy(places_c, sensed_c_.begin());
  for (std::size_t i = 0; i < kThermalPlaces; ++i) {
    follow_[i] = p.time_constant_s[i] > 0 ? -std::expm1(-1 / p.time_constant_s[i]) : 1;
    drift_per_sqrt_s_[i] = p.drift_k_per_sqrt_day[i] / std::sqrt(kSecondsPerDay);
    drifts_ = drifts_ || p.drift_k_per_sqrt_day[i] > 0;
    drift_k_[i] = p.drift_k_per_sqrt_day[i] * std::sqrt(p.days_since_calibration) * drift_noise_.normal();
  }
  read();
}

void ThermometerBank::step(PlaceTemperatures places_c) {
  for (std::size_t i = 0; i < kThermalPlaces; ++i) sensed_c_[i] += follow_[i] * (places_c[i] - sensed_c_[i]);
  if (drifts_) drift();
  read();
}

void ThermometerBank::drift() {
  for (std::size_t i = 0; i < kThermalPlaces; ++i) drift_k_[i] += drift_per_sqrt_s_[i] * drift_noise_.normal();
}

void ThermometerBank::read() {
  const auto& p = parameters_;
  for (std::size_t i = 0; i < kThermalPlaces; ++i) {
    const double error_k = p.offset_k[i] + p.gain[i] * (sensed_c_[i] - kCalibratedAtC) + drift_k_[i];
    const double shown_c = sensed_c_[i] + error_k + p.noise_k[i] * noise_.normal();
    readings_c_[i] = to_resolution(shown_c, p.resolution_k[i]);
  }
}

}  // namespace gyrotherm
