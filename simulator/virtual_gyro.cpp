// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_gyro.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulator/laboratory_file.hpp"

namespace gyrotherm::simulator {

namespace {

static_assert(static_cast<std::size_t>(thermal::ThermalOutput::h) + 1 == kBlockLocations);
static_assert(static_cast<std::size_t>(thermal::ThermalOutput::shell) + 1 == kThermalLocations);

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
          .unbalance = table.number("unbalance"),
          .unbalance_per_k = table.number("unbalance_per_k", 0)};
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
                .step_deg_per_h = table.number("step_deg_per_h"),
                .shortest_s = not_negative(table, "shortest_s", 0),
                .longest_s = not_negative(table, "longest_s", 0),
                .transient_deg_per_h = table.number("transient_deg_per_h", 0)};
  if (table.has("phase_modes")) hops.phase_modes = table.number("phase_modes");
  if (hops.phase_modes && !(std::abs(*hops.phase_modes) <= 0.5))
    table.note_error("phase_modes", fmt::format("{}, expected -0.5 to 0.5", *hops.phase_modes));
  if (hops.longest_s < hops.shortest_s)
    table.note_error("longest_s",
                     fmt::format("{} s, expected at least the shortest, {} s", hops.longest_s, hops.shortest_s));
  if (table.has("reach_modes") && !(hops.reach_modes > 0.5))
    table.note_error("reach_modes",
                     fmt::format("{}, expected more than the half mode that remains after a hop", hops.reach_modes));
  return hops;
}

CoefficientGrowth read_growth(const TomlTable& table) {
  CoefficientGrowth growth{
      .gas_flow = table.number("gas_flow"), .mirrors = {}, .backscatter = table.number("backscatter")};
  std::ranges::copy(numbers(table, "mirrors", growth.mirrors.size(), -1e6), growth.mirrors.begin());
  return growth;
}

HiddenLag read_lag(const TomlTable& table) {
  HiddenLag lag{.share = not_negative(table, "share"), .time_constant_s = time_constant_s(table, "time_constant_s")};
  if (lag.share > 1) table.note_error("share", fmt::format("{}, expected at most 1", lag.share));
  return lag;
}

Ageing read_ageing(const TomlTable& table) {
  Ageing ageing{.gas_flow = table.number("gas_flow_per_year"),
                .mirrors = {},
                .gas_balance = table.number("gas_balance_per_year")};
  std::ranges::copy(numbers(table, "mirrors_per_year", ageing.mirrors.size(), -1), ageing.mirrors.begin());
  return ageing;
}

StorageTemperatures read_storage_temperatures(const TomlTable& table) {
  constexpr int kMostTurns = 10000;
  StorageTemperatures storage{.turns = bounded<int>(table, "turns", table.integer("turns"), 0, kMostTurns),
                              .lowest_c = table.celsius("lowest").value,
                              .highest_c = table.celsius("highest").value};
  if (storage.highest_c < storage.lowest_c) table.note_error("highest", "expected at least \"lowest\"");
  return storage;
}

/// Reads the optional tables and keys of effects that a linear gyro does not have.
void read_slow_bias(const TomlTable& table, BiasPhysics& b) {
  if (table.has("growth")) b.growth = read_growth(table.table("growth"));
  if (table.has("lag")) {
    const auto lag = table.table("lag");
    if (lag.has("gas_flow")) b.lags.gas_flow = read_lag(lag.table("gas_flow"));
    if (lag.has("deformation")) b.lags.deformation = read_lag(lag.table("deformation"));
  }
  for (const auto& term : table.tables("relaxation"))
    b.relaxations.push_back({.time_constant_s = time_constant_s(term, "time_constant_s"),
                             .deg_per_h_per_k = term.number("deg_per_h_per_k")});
  for (const auto& phase : table.tables("warm_up"))
    b.warm_up.push_back(
        {.time_constant_s = time_constant_s(phase, "time_constant_s"), .deg_per_h = phase.number("deg_per_h")});
}

/// Reads a number in −most … most.
double read_bounded(const TomlTable& table, const char* key, double most, std::optional<double> fallback = {}) {
  const double value = table.number(key, fallback);
  if (!(std::abs(value) <= most)) table.note_error(key, fmt::format("{}, expected {} to {}", value, -most, most));
  return value;
}

SideWind read_side_wind(const TomlTable& table) {
  SideWind wind{.steady = read_bounded(table, "steady", kMostWind),
                .heating = read_bounded(table, "heating", kMostWind),
                .cooling = read_bounded(table, "cooling", kMostWind),
                .share = not_negative(table, "share"),
                .time_constant_s = time_constant_s(table, "time_constant_s"),
                .gap_w_per_k = not_negative(table, "gap_w_per_k")};
  if (wind.share > 1) table.note_error("share", fmt::format("{}, expected at most 1", wind.share));
  return wind;
}

PowerGrowth read_power_growth(const TomlTable& table) {
  return {.gain_per_k = read_bounded(table, "gain_per_k", kMostPowerGrowthPerK, 0),
          .preamplifier_per_k = read_bounded(table, "preamplifier_per_k", kMostPowerGrowthPerK, 0),
          .ballast_per_k = read_bounded(table, "ballast_per_k", kMostPowerGrowthPerK, 0),
          .split_per_k = read_bounded(table, "split_per_k", kMostPowerGrowthPerK, 0)};
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
  read_slow_bias(table, b);
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

thermal::ReducedModel apply_unequal_arms(thermal::ReducedModel model, const UnequalArms& arms) {
  share(input_power(model.powers_w, thermal::ThermalInput::gain_left),
        input_power(model.powers_w, thermal::ThermalInput::gain_right), arms.gain_left_over_right);
  share(input_power(model.powers_w, thermal::ThermalInput::ballast_left),
        input_power(model.powers_w, thermal::ThermalInput::ballast_right), arms.ballast_left_over_right);
  add_lead(model, thermal::ThermalOutput::gain_left, arms.left_lead_w_per_k);
  add_lead(model, thermal::ThermalOutput::gain_right, arms.right_lead_w_per_k);
  return model;
}

namespace {

double shell_c(InnerTemperatures inner_c) { return inner_c[static_cast<std::size_t>(thermal::ThermalOutput::shell)]; }

/// Returns the added heat of a switched-on gyro at rest. The heat and the temperatures at rest depend on each other, so
/// they are found by iteration; each round reduces the error by a factor of about 100.
thermal::ThermalPowers heat_at_rest_w(AddedHeat& heat, const thermal::ReducedModel& model,
                                      const ReducedGyroParameters& parameters) {
  constexpr int kRounds = 10;
  thermal::ThermalPowers added_w{};
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd inner_c =
        model.outputs * states_at_rest(add_powers(model, added_w), parameters.film, parameters.start_c);
    const InnerTemperatures at_rest_c(inner_c.data(), thermal::kThermalOutputs);
    heat.settle({parameters.start_c}, shell_c(at_rest_c));
    added_w = heat.watts(at_rest_c);
  }
  return added_w;
}

thermal::ReducedTransientOptions transient_options(AddedHeat& heat, const thermal::ReducedModel& model,
                                                   const ReducedGyroParameters& parameters) {
  thermal::ReducedTransientOptions options{.start = {parameters.start_c},
                                           .cold = parameters.cold,
                                           .film = parameters.film,
                                           .seconds_per_update = parameters.seconds_per_update};
  if (!heat.has_effect()) return options;
  options.added_w = parameters.cold ? thermal::ThermalPowers{} : heat_at_rest_w(heat, model, parameters);
  return options;
}

}  // namespace

ReducedGyro::ReducedGyro(const ReducedGyroParameters& parameters, const GyroHistory& past)
    : ReducedGyro(apply_unequal_arms(parameters.model, parameters.arms), parameters, past) {}

ReducedGyro::ReducedGyro(const thermal::ReducedModel& model, const ReducedGyroParameters& parameters,
                         const GyroHistory& past)
    : heat_(model.powers_w, parameters.wind, parameters.power_growth),
      reduced_(model, transient_options(heat_, model, parameters)),
      bias_(parameters.bias, reduced_.outputs_c(), past) {}

void ReducedGyro::step(Celsius air, double output) {
  if (heat_.has_effect()) {
    heat_.follow(air, shell_c(inner_c()), output);
    reduced_.step(air, heat_.watts(inner_c()));
  } else {
    reduced_.step(air);
  }
  bias_.step(reduced_.outputs_c());
}

void ReducedGyro::switch_on(bool on) {
  reduced_.switch_on(on);
  heat_.switch_on(on);
  if (on) bias_.restart();
}

Celsius cabinet_at_rest(const ReducedGyroParameters& parameters) {
  const auto model = apply_unequal_arms(parameters.model, parameters.arms);
  if (parameters.cold) return {parameters.start_c};
  AddedHeat heat(model.powers_w, parameters.wind, parameters.power_growth);
  const auto added_w = heat.has_effect() ? heat_at_rest_w(heat, model, parameters) : thermal::ThermalPowers{};
  const Eigen::VectorXd inner_c =
      model.outputs * states_at_rest(add_powers(model, added_w), parameters.film, parameters.start_c);
  return {shell_c(InnerTemperatures(inner_c.data(), thermal::kThermalOutputs))};
}

ReducedGyroParameters read_reduced_gyro(const TomlTable& table) {
  const auto thermal = table.table("thermal");
  (void)thermal.text("gyro");
  ReducedGyroParameters p;
  p.start_c = thermal.celsius("start").value;
  p.film =
      thermal.choice("film", {"chamber", "still"}) == "still" ? thermal::GyroFilm::still : thermal::GyroFilm::chamber;
  p.arms = {.gain_left_over_right = positive(thermal, "gain_left_over_right"),
            .ballast_left_over_right = positive(thermal, "ballast_left_over_right"),
            .left_lead_w_per_k = not_negative(thermal, "left_lead_w_per_k"),
            .right_lead_w_per_k = not_negative(thermal, "right_lead_w_per_k")};
  if (thermal.has("side_wind")) p.wind = read_side_wind(thermal.table("side_wind"));
  if (thermal.has("power_growth")) p.power_growth = read_power_growth(thermal.table("power_growth"));
  const auto bias = table.table("bias");
  p.bias = read_physics(bias);
  if (bias.has("ageing")) p.ageing = read_ageing(bias.table("ageing"));
  if (bias.has("storage")) p.storage = read_storage_temperatures(bias.table("storage"));
  if (table.has("power_on")) p.cold = table.table("power_on").boolean("cold", false);
  const auto spread = thermal.table("spread");
  p.spread = read_thermal_spread(spread);
  p.lead_spread = not_negative(spread, "leads");
  return p;
}

}  // namespace gyrotherm::simulator
