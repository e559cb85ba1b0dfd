// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_gyro.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "simulator/laboratory_file.hpp"

namespace gyrotherm::simulator {

namespace {

static_assert(static_cast<std::size_t>(thermal::ThermalOutput::h) + 1 == kBlockPlaces);
static_assert(static_cast<std::size_t>(thermal::ThermalOutput::shell) + 1 == kThermalPlaces);

/// The powers come after the ambient.
double& power_w(thermal::ReducedModel& model, thermal::ThermalInput input) {
  return model.powers_w[static_cast<std::size_t>(input) - 1];
}

void share(double& left_w, double& right_w, double left_over_right) {
  const double factor = left_w * left_over_right;
  const double sum = left_w + right_w;
  if (factor + right_w == 0) return;
  left_w = sum * factor / (factor + right_w);
  right_w = sum - left_w;
}

void add_lead(thermal::ReducedModel& model, thermal::ThermalOutput arm, double w_per_k) {
  const auto row = [&](thermal::ThermalOutput output) { return model.outputs.row(static_cast<Eigen::Index>(output)); };
  const Eigen::VectorXd drop = (row(arm) - row(thermal::ThermalOutput::shell)).transpose();
  model.conduction += w_per_k * drop * drop.transpose();
}

GasFlow read_flow(const TomlTable& table) {
  return {.shift_deg_per_h_per_cm_per_s = table.number("shift_deg_per_h_per_cm_per_s"),
          .velocity_cm_per_s = table.number("velocity_cm_per_s"),
          .exponent = table.number("exponent"),
          .unbalance = table.number("unbalance")};
}

BackscatterWave read_wave(const TomlTable& table) {
  return {.deg_per_h = table.number("deg_per_h"),
          .period_k = positive(table, "period_k"),
          .phase_deg = table.number("phase_deg", 0)};
}

HysteresisPlay read_play(const TomlTable& table) {
  return {.half_width_k = positive(table, "half_width_k"), .deg_per_h = table.number("deg_per_h")};
}

ModeHops read_mode_hops(const TomlTable& table) {
  ModeHops hops{.kelvin_per_mode = not_negative(table, "kelvin_per_mode"),
                .reach_modes = table.number("reach_modes"),
                .step_deg_per_h = table.number("step_deg_per_h")};
  if (table.has("reach_modes") && !(hops.reach_modes > 0.5))
    table.mistake("reach_modes",
                  fmt::format("{}, expected more than the half mode that remains after a hop", hops.reach_modes));
  return hops;
}

BiasPhysics read_physics(const TomlTable& table) {
  BiasPhysics b;
  b.flow = read_flow(table.table("gas_flow"));
  const auto mirrors = numbers(table, "mirror_deg_per_h_per_k", b.mirror_deg_per_h_per_k.size(), -1e6);
  std::ranges::copy(mirrors, b.mirror_deg_per_h_per_k.begin());
  b.linear_deg_per_h_per_k = table.number("linear_deg_per_h_per_k");
  b.quadratic_deg_per_h_per_k2 = table.number("quadratic_deg_per_h_per_k2");
  for (const auto& wave : table.tables("wave")) b.waves.push_back(read_wave(wave));
  for (const auto& play : table.tables("play")) b.plays.push_back(read_play(play));
  if (table.has("mode_hops")) b.mode_hops = read_mode_hops(table.table("mode_hops"));
  return b;
}

thermal::ThermalSpread read_thermal_spread(const TomlTable& table) {
  return {.capacity = not_negative(table, "capacity"),
          .gap = not_negative(table, "gap"),
          .film = not_negative(table, "film"),
          .power = not_negative(table, "power"),
          .arms = not_negative(table, "arms")};
}

}  // namespace

thermal::ReducedModel with_unequal_arms(thermal::ReducedModel model, const UnequalArms& arms) {
  share(power_w(model, thermal::ThermalInput::gain_left), power_w(model, thermal::ThermalInput::gain_right),
        arms.gain_left_over_right);
  share(power_w(model, thermal::ThermalInput::ballast_left), power_w(model, thermal::ThermalInput::ballast_right),
        arms.ballast_left_over_right);
  add_lead(model, thermal::ThermalOutput::gain_left, arms.left_lead_w_per_k);
  add_lead(model, thermal::ThermalOutput::gain_right, arms.right_lead_w_per_k);
  return model;
}

ReducedGyro::ReducedGyro(const ReducedGyroParameters& parameters)
    : reduced_(with_unequal_arms(parameters.model, parameters.arms),
               {.start = {parameters.start_c}, .film = parameters.film}),
      bias_(parameters.bias, reduced_.outputs_c()) {}

void ReducedGyro::step(Celsius air) {
  reduced_.step(air);
  bias_.step(reduced_.outputs_c());
}

ReducedGyroParameters read_reduced_gyro(const TomlTable& table) {
  const auto thermal = table.table("thermal");
  (void)thermal.text("gyro");  // read by gyro_model_of
  ReducedGyroParameters p;
  p.start_c = thermal.celsius("start").value;
  p.film =
      thermal.choice("film", {"chamber", "still"}) == "still" ? thermal::GyroFilm::still : thermal::GyroFilm::chamber;
  p.arms = {.gain_left_over_right = positive(thermal, "gain_left_over_right"),
            .ballast_left_over_right = positive(thermal, "ballast_left_over_right"),
            .left_lead_w_per_k = not_negative(thermal, "left_lead_w_per_k"),
            .right_lead_w_per_k = not_negative(thermal, "right_lead_w_per_k")};
  p.bias = read_physics(table.table("bias"));
  const auto spread = thermal.table("spread");
  p.spread = read_thermal_spread(spread);
  p.lead_spread = not_negative(spread, "leads");
  return p;
}

}  // namespace gyrotherm::simulator
