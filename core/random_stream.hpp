/// Random numbers that are the same on every machine: the standard's generator with our own mapping to reals, and one
/// stream per purpose, so that a new purpose disturbs no other.
#pragma once

#include <cstdint>
#include <random>

namespace gyrotherm {

enum class RandomPurpose : std::uint64_t {
  capacity_spread = 1,
  film_spread = 2,
  bias_spread = 3,
  thermometer_offset = 4,
  turn_on = 5,
  air_noise = 6,
  thermometer_noise = 7,
  angle_noise = 8,
  drift = 9,
  thermal_spread = 10,
  thermometer_gain = 11,
  thermometer_time_constant = 12,
  thermometer_drift = 13,
  bias_instability = 14,
  rate_random_walk = 15,
  turn_on_repeatability = 16,
  lead_spread = 17,
};

/// One step of the splitmix64 mixer (Steele, Lea & Flood 2014).
[[nodiscard]] std::uint64_t splitmix64(std::uint64_t x);

/// One purpose's numbers under one seed.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, RandomPurpose purpose);

  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform();
  /// Mean 0, standard deviation 1; Marsaglia's polar method.
  [[nodiscard]] double normal();
  /// exp(sigma · normal): median 1.
  [[nodiscard]] double log_normal(double sigma);

 private:
  std::mt19937_64 bits_;
  double spare_{};
  bool has_spare_{};
};

}  // namespace gyrotherm
