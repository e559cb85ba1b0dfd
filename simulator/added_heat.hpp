// SPDX-License-Identifier: Apache-2.0
/// Heat that a hard rig adds to what the gyro's thermal model knows of: of a fan that blows from one side, and of
/// powers that follow temperature. Both are off by default.
#pragma once

#include "core/quantity.hpp"
#include "simulator/gyro_bias.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::simulator {

/// So that a side's film stays above 0 whatever heater and cooler do.
inline constexpr double kMostWind = 0.45;

/// [virtual.thermal.side_wind]: the film of the cabinet's left half is 1 + w times the model's, that of the right half
/// 1 − w times. Heater and cooler stand in the stream, so that w follows them. The reduced model has one film all
/// around; what the two halves make of it is a law of its own (AddedHeat). Off while `gap_w_per_k` is 0.
struct SideWind {
  double steady{};             ///< w while neither heats nor cools; −kMostWind … kMostWind, as the next two
  double heating{};            ///< added to it at full heating
  double cooling{};            ///< … at full cooling
  double share{};              ///< of air less cabinet by which w = 1 parts the halves from their mean; 0 … 1
  double time_constant_s = 1;  ///< with which they part; 1 or more
  double gap_w_per_k{};        ///< from one half to its side of the block
};

/// Such that no power is below 0 between −60 and 80 °C.
inline constexpr double kMostPowerGrowthPerK = 0.01;

/// [virtual.thermal.power_growth]: P = P₀ (1 + α (T − 20 °C)), T the source's own temperature (the ballasts': the
/// block's); and what goes over from the right gain arm to the left. Each −kMostPowerGrowthPerK … kMostPowerGrowthPerK.
struct PowerGrowth {
  double gain_per_k{};          ///< α of the gain arms
  double preamplifier_per_k{};  ///< …
  double ballast_per_k{};       ///< …
  double split_per_k{};         ///< of the gain arms' mean power, per kelvin of the block above 20 °C
};

/// The heat that comes to the model's inputs, above its powers. Of the wind, with θ by how much each half of the
/// cabinet is from their mean: τ dθ/dt = s w (T_air − T_cabinet) − θ, and G θ comes to the left side of the block, half
/// of it where the gain arm is, half where the ballast is; as much leaves the right side. What θ loses by G is in s and
/// τ.
class AddedHeat {
 public:
  /// `powers_w`: those that the law of PowerGrowth has at 20 °C.
  AddedHeat(const thermal::ThermalPowers& powers_w, const SideWind& wind, const PowerGrowth& growth);

  [[nodiscard]] bool is_any() const;
  /// The wind has blown on a cabinet at `shell_c` for long, while nothing heated or cooled.
  void rest(Celsius air, double shell_c);
  /// One second of wind; `output` of heater (positive) and cooler (negative), −1 … 1.
  void follow(Celsius air, double shell_c, double output);
  /// The gyro's power: without it its growth is nothing.
  void switch_on(bool on) { on_ = on; }
  /// With the gyro's temperatures here and the wind where it is.
  [[nodiscard]] thermal::ThermalPowers watts(InnerTemperatures inner_c) const;

 private:
  thermal::ThermalPowers powers_w_;
  SideWind wind_;
  PowerGrowth growth_;
  double closes_;      ///< share of the difference from its end that θ closes in a second
  double parted_k_{};  ///< θ
  bool on_ = true;
};

}  // namespace gyrotherm::simulator
