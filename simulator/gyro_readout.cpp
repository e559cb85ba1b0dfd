#include "simulator/gyro_readout.hpp"

#include <cmath>

namespace gyrotherm {

GyroReadout::GyroReadout(const ReadoutParameters& parameters, std::uint64_t seed)
    : parameters_(parameters),
      angle_noise_(seed, RandomPurpose::angle_noise),
      drift_noise_(seed, RandomPurpose::drift),
      drift_memory_(std::exp(-1 / parameters.drift_time_s)),
      drift_deg_per_h_(parameters.drift_deg_per_h * drift_noise_.normal()) {}

void GyroReadout::step(DegreesPerHour thermal_bias) {
  const auto& p = parameters_;
  const DegreesPerHour rate = thermal_bias + drift() + DegreesPerHour{p.earth_rate_deg_per_h};
  angle_arcsec_ += rate.value + 60 * p.angle_random_walk_deg_per_sqrt_h * angle_noise_.normal();
  pulses_ = static_cast<std::int64_t>(std::floor(angle_arcsec_ / p.arcsec_per_pulse));
  ++seconds_;
  const double fresh = p.drift_deg_per_h * std::sqrt(1 - drift_memory_ * drift_memory_);
  drift_deg_per_h_ = drift_memory_ * drift_deg_per_h_ + fresh * drift_noise_.normal();
}

DegreesPerHour GyroReadout::drift() const { return {drift_deg_per_h_ + parameters_.turn_on_deg_per_h}; }

std::int64_t GyroReadout::device_time_us() const {
  return std::llround(static_cast<double>(seconds_) * (1e6 + parameters_.clock_skew_ppm));
}

}  // namespace gyrotherm
