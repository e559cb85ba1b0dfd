/// [virtual.bias] of the finite-element gyro: what each contribution of the bias physics (gyro_bias.hpp) is worth.
#pragma once

#include <array>
#include <vector>

namespace gyrotherm {

/// Flow of the gas in the two discharge arms, against each other along the light's path.
struct GasFlow {
  double shift_deg_per_h_per_cm_per_s{};  ///< of the bias per unbalance of the flows
  double velocity_cm_per_s{};             ///< in each arm at 20 °C and nominal current
  double exponent{};                      ///< of the arm's absolute temperature: that of the gas' viscosity
  double unbalance{};                     ///< relative, of the arms' currents and bores: (left − right) / mean
};

/// One periodic contribution of the mirrors' backscatter, whose phase follows the length of the light's path.
struct BackscatterWave {
  double deg_per_h{};
  double period_k{};  ///< of the path's temperature
  double phase_deg{};
};

/// One play operator: friction between parts that expand differently.
struct HysteresisPlay {
  double half_width_k{};
  double deg_per_h{};  ///< while the temperature rises beyond the half-width; the opposite while it falls
};

/// Steps of the path-length control from one longitudinal mode to the next. Off while kelvin_per_mode is 0.
struct ModeHops {
  double kelvin_per_mode{};  ///< of the path's temperature, for one wavelength of its length
  double reach_modes{};      ///< what the actuator can follow, to either side
  double step_deg_per_h{};   ///< of the bias, per mode
};

struct BiasPhysics {
  GasFlow flow;
  std::array<double, 4> mirror_deg_per_h_per_k{};  ///< of mirrors B, C, F, H above the block's mean
  double linear_deg_per_h_per_k{};                 ///< of the block's mean above 20 °C
  double quadratic_deg_per_h_per_k2{};
  std::vector<BackscatterWave> waves;
  std::vector<HysteresisPlay> plays;
  ModeHops mode_hops;
};

}  // namespace gyrotherm
