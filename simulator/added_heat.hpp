// SPDX-License-Identifier: Apache-2.0
/// Heat that a hard rig adds to the gyro's thermal model: a fan that blows from one side, powers that depend on
/// temperature, and other bodies on a common bracket. Everything is off by default.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/quantity.hpp"
#include "simulator/gyro_bias.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::simulator {

/// Limit of each wind parameter. Within it the film of each side remains positive at any output of heater and cooler.
inline constexpr double kMostWind = 0.45;

/// [virtual.thermal.side_wind]: the film of the cabinet's left half is 1 + w times the model's, the film of the right
/// half 1 − w times. Heater and cooler are in the air stream, so w follows their output. The reduced model has one film
/// all around; AddedHeat adds the difference between the halves. Off while `gap_w_per_k` is 0. `steady`, `heating` and
/// `cooling` are in −kMostWind … kMostWind.
struct SideWind {
  /// w while the machinery neither heats nor cools.
  double steady{};
  /// Added to w at full heating, and at full cooling.
  double heating{};
  double cooling{};
  /// Steady-state difference between the temperature of each half and the mean of both halves at w = 1, as a share of
  /// (air − cabinet); 0 … 1.
  double share{};
  /// Time constant of this difference; 1 or more.
  double time_constant_s = 1;
  /// Conductance from one half of the cabinet to the block on its side.
  double gap_w_per_k{};
};

/// Limit of each coefficient. Within it no power is negative between −60 and 80 °C.
inline constexpr double kMostPowerGrowthPerK = 0.01;

/// [virtual.thermal.power_growth]: P = P₀ (1 + α (T − 20 °C)), where T is the temperature of the heat source (for the
/// ballasts, that of the block), and a shift of power from the right gain arm to the left. All values are in
/// −kMostPowerGrowthPerK … kMostPowerGrowthPerK.
struct PowerGrowth {
  /// α of the gain arms, of the preamplifier and of the ballasts.
  double gain_per_k{};
  double preamplifier_per_k{};
  double ballast_per_k{};
  /// Power shifted from right to left per kelvin of the block above 20 °C, as a share of the gain arms' mean power.
  double split_per_k{};
};

/// The heat that is added to the powers of the model. Let θ be the temperature difference of each half of the cabinet
/// from the mean of both halves. The wind drives it: τ dθ/dt = s w (T_air − T_cabinet) − θ. The left side of the block
/// receives G θ, half of it at the gain arm and half at the ballast; the right side loses the same heat. The values of
/// s and τ already include the loss of θ through G.
class AddedHeat {
 public:
  /// `powers_w` are the powers at 20 °C.
  AddedHeat(const thermal::ThermalPowers& powers_w, const SideWind& wind, const PowerGrowth& growth);

  [[nodiscard]] bool has_effect() const;
  /// Sets the wind to its steady state: cabinet at `shell_c`, machinery neither heating nor cooling.
  void settle(Celsius air, double shell_c);
  /// Advances the wind by one second. `output` is −1 (full cooling) … 1 (full heating).
  void follow(Celsius air, double shell_c, double output);
  /// Switches the gyro's power. The growth of the powers is zero while it is off.
  void switch_on(bool on) { on_ = on; }
  /// Returns the added heat at the gyro's temperatures `inner_c` and the present wind.
  [[nodiscard]] thermal::ThermalPowers watts(InnerTemperatures inner_c) const;

 private:
  thermal::ThermalPowers powers_w_;
  SideWind wind_;
  PowerGrowth growth_;
  /// Fraction of its distance from the final value that θ covers in one second.
  double closing_share_;
  double separation_k_{};  ///< θ
  bool on_ = true;
};

/// Upper limit of a bracket's share. At a share of 1 no heat would reach the air.
inline constexpr double kMostBracketShare = 0.9;

/// [[virtual.bracket]]: the fraction `share` of each cabinet's film leads to the bracket, the remainder to the air. The
/// bracket exchanges heat only with the cabinets. It follows their mean temperature, so the heat that one body loses to
/// the bracket reaches the others. If n bodies have equal films hA, time_constant_s is the heat capacity of the bracket
/// divided by n · share · hA.
struct BracketParameters {
  /// Indices of the units. All axes of a unit are on the bracket.
  std::vector<std::size_t> units;
  double share{};              ///< 0 … kMostBracketShare
  double time_constant_s = 1;  ///< 1 or more
};

/// A bracket that carries several bodies in the chamber's air. The bodies heat each other through it.
class Bracket {
 public:
  Bracket(const BracketParameters& parameters, Celsius start);

  /// Returns the effective air temperature of a body on it: air + share · (bracket − air).
  [[nodiscard]] Celsius effective_air(Celsius air) const;
  /// Advances by one second. `cabinets` is the mean temperature of the cabinets.
  void follow(Celsius cabinets);
  [[nodiscard]] Celsius temperature() const { return at_; }

 private:
  double share_;
  /// Fraction of its difference from the cabinets that the bracket closes in one second.
  double closing_share_;
  Celsius at_;
};

/// Returns the steady-state temperature of a bracket in air of this temperature. `cabinets` converts an effective air
/// temperature to the steady-state mean temperature of the cabinets on the bracket.
[[nodiscard]] Celsius bracket_at_rest(double share, Celsius air, const std::function<Celsius(Celsius)>& cabinets);

}  // namespace gyrotherm::simulator
