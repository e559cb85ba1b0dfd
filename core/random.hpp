// SPDX-License-Identifier: Apache-2.0
/// Random numbers that are identical on every machine. The generator is the standard library's; the distributions are
/// implemented here, because each standard library implements them differently.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace gyrotherm {

/// Draws a uniform number from [0, 1), using the upper 53 bits of one generator output.
[[nodiscard]] inline double uniform(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11U) * 0x1p-53;
}

/// Draws a uniform whole number from 0 to count − 1.
[[nodiscard]] inline std::int64_t draw_index(std::int64_t count, std::mt19937_64& generator) {
  return static_cast<std::int64_t>(uniform(generator) * static_cast<double>(count));
}

/// Computes one step of the splitmix64 mixer (Steele, Lea & Flood 2014).
[[nodiscard]] constexpr std::uint64_t splitmix64(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

/// Purposes of the random streams of the virtual laboratory. A number is never reused for another purpose: a simulated
/// record must remain reproducible from its seed.
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
  hard_spread = 18,
  thermometer_calendar = 19,
  storage = 20,
  mode_hops = 21,
  lost_pulses = 22,
  ageing = 23,
  thermometer_spikes = 24,
  side_wind = 25,
  power_growth = 26,
  dead_band = 27,
  own_temperature = 28,
  own_values = 29,
};

/// The stream of random numbers for one seed and one purpose. Because each purpose has its own stream, a new purpose
/// does not change the numbers of existing ones.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, RandomPurpose purpose)
      : bits_(splitmix64(splitmix64(seed) + static_cast<std::uint64_t>(purpose))) {}

  /// Draws a uniform number from [0, 1) with a resolution of 53 bits.
  [[nodiscard]] double uniform() { return gyrotherm::uniform(bits_); }

  /// Draws from the normal distribution of mean 0 and standard deviation 1 by Marsaglia's polar method.
  [[nodiscard]] double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double x{};
    double y{};
    double square{};
    do {
      x = 2 * uniform() - 1;
      y = 2 * uniform() - 1;
      square = x * x + y * y;
    } while (square >= 1 || square == 0);
    const double factor = std::sqrt(-2 * std::log(square) / square);
    spare_ = y * factor;
    has_spare_ = true;
    return x * factor;
  }

  /// Draws exp(sigma · normal()), whose median is 1.
  [[nodiscard]] double log_normal(double sigma) { return std::exp(sigma * normal()); }

 private:
  std::mt19937_64 bits_;
  double spare_{};
  bool has_spare_{};
};

}  // namespace gyrotherm
