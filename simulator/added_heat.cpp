// SPDX-License-Identifier: Apache-2.0
#include "simulator/added_heat.hpp"

#include <cassert>
#include <cmath>

namespace gyrotherm::simulator {
namespace {

constexpr double kPowerReferenceC = 20;

/// Returns w. The films of the halves are 1 + w and 1 − w.
double relative_wind(const SideWind& wind, double output) {
  return wind.steady + (output > 0 ? wind.heating * output : -wind.cooling * output);
}

/// Returns the difference of each power from its value at 20 °C.
thermal::ThermalPowers added_growth_w(const thermal::ThermalPowers& powers_w, const PowerGrowth& growth,
                                      InnerTemperatures inner_c) {
  using Input = thermal::ThermalInput;
  using Output = thermal::ThermalOutput;
  const auto above_k = [&](Output output) { return inner_c[static_cast<std::size_t>(output)] - kPowerReferenceC; };
  auto added_w = powers_w;
  const double shifted_w = growth.split_per_k * above_k(Output::block) *
                           (input_power(added_w, Input::gain_left) + input_power(added_w, Input::gain_right)) / 2;
  input_power(added_w, Input::gain_left) *= growth.gain_per_k * above_k(Output::gain_left);
  input_power(added_w, Input::gain_right) *= growth.gain_per_k * above_k(Output::gain_right);
  input_power(added_w, Input::preamplifier) *= growth.preamplifier_per_k * above_k(Output::preamplifier);
  input_power(added_w, Input::ballast_left) *= growth.ballast_per_k * above_k(Output::block);
  input_power(added_w, Input::ballast_right) *= growth.ballast_per_k * above_k(Output::block);
  input_power(added_w, Input::gain_left) += shifted_w;
  input_power(added_w, Input::gain_right) -= shifted_w;
  return added_w;
}

/// Returns the effective air temperature of a body on a bracket.
Celsius mix_air(double share, Celsius air, Celsius bracket) {
  return {air.value + share * (bracket.value - air.value)};
}

}  // namespace

AddedHeat::AddedHeat(const thermal::ThermalPowers& powers_w, const SideWind& wind, const PowerGrowth& growth)
    : powers_w_(powers_w), wind_(wind), growth_(growth), closing_share_(closing_share(wind.time_constant_s)) {}

bool AddedHeat::has_effect() const {
  return wind_.gap_w_per_k != 0 || growth_.gain_per_k != 0 || growth_.preamplifier_per_k != 0 ||
         growth_.ballast_per_k != 0 || growth_.split_per_k != 0;
}

void AddedHeat::settle(Celsius air, double shell_c) {
  separation_k_ = wind_.share * relative_wind(wind_, 0) * (air.value - shell_c);
}

void AddedHeat::follow(Celsius air, double shell_c, double output) {
  separation_k_ +=
      closing_share_ * (wind_.share * relative_wind(wind_, output) * (air.value - shell_c) - separation_k_);
}

thermal::ThermalPowers AddedHeat::watts(InnerTemperatures inner_c) const {
  using Input = thermal::ThermalInput;
  auto added_w = on_ ? added_growth_w(powers_w_, growth_, inner_c) : thermal::ThermalPowers{};
  const double half_w = wind_.gap_w_per_k * separation_k_ / 2;
  for (const auto left : {Input::gain_left, Input::ballast_left}) input_power(added_w, left) += half_w;
  for (const auto right : {Input::gain_right, Input::ballast_right}) input_power(added_w, right) -= half_w;
  return added_w;
}

Bracket::Bracket(const BracketParameters& parameters, Celsius start)
    : share_(parameters.share), closing_share_(closing_share(parameters.time_constant_s)), at_(start) {
  assert(0 <= share_ && share_ <= kMostBracketShare && parameters.time_constant_s >= 1);
}

Celsius Bracket::effective_air(Celsius air) const { return mix_air(share_, air, at_); }

void Bracket::follow(Celsius cabinets) { at_.value += closing_share_ * (cabinets.value - at_.value); }

Celsius bracket_at_rest(double share, Celsius air, const std::function<Celsius(Celsius)>& cabinets) {
  constexpr int kMostRounds = 50;
  constexpr double kSettledK = 1e-10;
  Celsius bracket = air;
  for (int round = 0; round < kMostRounds; ++round) {
    // The excess of a cabinet over its effective air hardly depends on that air, so each round reduces the error by a
    // factor of about 100.
    const auto seen = mix_air(share, air, bracket);
    const double above_k = (cabinets(seen).value - seen.value) / (1 - share);
    const double step_k = air.value + above_k - bracket.value;
    bracket.value += step_k;
    if (std::abs(step_k) <= kSettledK) break;
  }
  return bracket;
}

}  // namespace gyrotherm::simulator
