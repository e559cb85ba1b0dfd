/// What the temperatures inside a ring laser gyro make of its bias: one contribution per physical source, each fed by
/// the gain arms, the mirrors and the block's mean, which no thermometer shows.
#pragma once

#include <span>
#include <vector>

#include "core/quantity.hpp"
#include "simulator/bias_parameters.hpp"
#include "simulator/hysteresis.hpp"
#include "thermal/reduced/thermal_system.hpp"

namespace gyrotherm {

using InnerTemperatures = std::span<const double, kThermalOutputs>;  ///< °C, in the order of ThermalOutput

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

/// What the light's path has grown by follows this: the mean of block and mirrors, half each.
[[nodiscard]] double light_path_c(InnerTemperatures inner_c);

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

}  // namespace gyrotherm
