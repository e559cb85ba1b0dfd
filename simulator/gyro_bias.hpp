// SPDX-License-Identifier: Apache-2.0
/// What the temperatures inside a ring laser gyro make of its bias: one contribution per physical source, each fed by
/// the gain arms, the mirrors and the block's mean, which no thermometer shows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/quantity.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm::simulator {

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

/// The play operator (Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989, section 2): follows its input only
/// once that has moved by the half-width. Independent of rate: only turning points count.
class Play {
 public:
  /// `half_width_k` ≥ 0; starts midway.
  Play(double half_width_k, double input_c) : half_width_k_(half_width_k), output_c_(input_c) {}

  void follow(double input_c) {
    output_c_ = std::clamp(output_c_, input_c - half_width_k_, input_c + half_width_k_);
    lag_k_ = input_c - output_c_;
  }
  /// Input less output: between −half_width and half_width, positive after heating.
  [[nodiscard]] double lag_k() const { return lag_k_; }

 private:
  double half_width_k_;
  double output_c_;
  double lag_k_{};
};

/// The mode that the path-length control is locked to, as the light's path grows by one wavelength per
/// kelvin_per_mode: it stays until its actuator is at its end, then takes the mode nearest to the actuator's middle.
class ModeLock {
 public:
  /// Locked at `start_c` with its actuator in the middle.
  ModeLock(const ModeHops& hops, double start_c) : hops_(hops), start_c_(start_c) {}

  void follow(double path_c) {
    if (hops_.kelvin_per_mode == 0) return;
    const double wanted = (path_c - start_c_) / hops_.kelvin_per_mode;
    if (std::abs(wanted - mode_) > hops_.reach_modes) mode_ = std::round(wanted);
  }
  /// Whole wavelengths from where it started.
  [[nodiscard]] double mode() const { return mode_; }

 private:
  ModeHops hops_;
  double start_c_;
  double mode_{};
};

using InnerTemperatures = std::span<const double, thermal::kThermalOutputs>;  ///< °C, in the order of ThermalOutput

/// Langmuir flow: in each arm the discharge drives the gas along the light, at v₀ (T/293.15 K)^p, T the arm's; the two
/// arms oppose each other, and what is left drags the light (Aronowitz & Lim, Opt. Eng. 18, 1979): k {(1 + u/2) v_left
/// − (1 − u/2) v_right}. An arm warmer by 1 K at 20 °C is worth k v₀ p / 293.15.
[[nodiscard]] double gas_flow_deg_per_h(const GasFlow& flow, double left_c, double right_c);

/// Σ_m g_m (T_m − T_block) over the mirrors: a cavity that expands unevenly is not the same for both beams.
[[nodiscard]] double deformation_deg_per_h(const BiasPhysics& physics, InnerTemperatures inner_c);

/// k₁ x + k₂ x², x the block's mean less 20 °C.
[[nodiscard]] double temperature_deg_per_h(const BiasPhysics& physics, double block_c);

/// Σ u sin(2π x/period + phase), x the path's temperature less 20 °C.
[[nodiscard]] double backscatter_deg_per_h(const std::vector<BackscatterWave>& waves, double path_c);

/// °/h each; the bias is their sum.
struct BiasParts {
  double gas_flow{};
  double deformation{};
  double temperature{};
  double backscatter{};
  double hysteresis{};
  double mode_hops{};
};

/// The contributions together, with the memory that hysteresis and mode hops need.
class GyroBias {
 public:
  /// At rest: no play is engaged, the mode is the one that was locked there.
  GyroBias(const BiasPhysics& physics, InnerTemperatures start_c);

  /// The temperatures have come here.
  void step(InnerTemperatures now_c);

  [[nodiscard]] const BiasParts& parts() const { return parts_; }
  [[nodiscard]] DegreesPerHour total() const;

 private:
  BiasPhysics physics_;
  std::vector<Play> plays_;
  ModeLock lock_;
  BiasParts parts_;
};

}  // namespace gyrotherm::simulator
