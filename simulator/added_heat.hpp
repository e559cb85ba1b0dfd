// SPDX-License-Identifier: Apache-2.0
/// Heat that a hard rig adds to that of the gyro's thermal model: from a fan that blows from one side, from powers that
/// depend on temperature, and from the other bodies on a common bracket. All of it is off by default.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

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

/// Upper limit of a bracket's share: with all of the film to the bracket, no heat reaches the air.
inline constexpr double kMostBracketShare = 0.9;

/// [[virtual.bracket]]: `share` of each cabinet's film leads to the bracket, the remainder to the air. The bracket
/// gives heat to nothing else: it follows the mean of the cabinets, and the heat that one body loses to it reaches the
/// others. With equal films hA of n bodies, time_constant_s is its heat capacity over n · share · hA.
struct BracketParameters {
  std::vector<std::size_t> units;  ///< by index; with all their axes
  double share{};                  ///< 0 … kMostBracketShare
  double time_constant_s = 1;      ///< 1 or more
};

/// A bracket that carries several bodies in the chamber's air, through which they heat each other.
class Bracket {
 public:
  Bracket(const BracketParameters& parameters, Celsius start);

  /// Returns the effective air temperature of a body on it: air + share · (bracket − air).
  [[nodiscard]] Celsius seen_by_a_body(Celsius air) const;
  /// Advances by one second with the mean of the cabinets at this temperature.
  void follow(Celsius cabinets);
  [[nodiscard]] Celsius temperature() const { return at_; }

 private:
  double share_;
  double closes_;  ///< share of the difference that a second closes
  Celsius at_;
};

/// Returns the temperature of a bracket at rest in air of this temperature. `cabinets` returns the mean temperature of
/// its bodies' cabinets at rest in a given effective air.
[[nodiscard]] Celsius bracket_at_rest(double share, Celsius air, const std::function<Celsius(Celsius)>& cabinets);

}  // namespace gyrotherm::simulator
