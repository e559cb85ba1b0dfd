// SPDX-License-Identifier: Apache-2.0
/// All parameters of the virtual laboratory, as given by the [virtual] table of a rig file.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "simulator/added_heat.hpp"
#include "simulator/gyro_bias.hpp"
#include "simulator/thermal/reduced/reduced_model.hpp"
#include "simulator/thermal/reduced/thermal_system.hpp"

namespace gyrotherm::simulator {

/// [virtual.plant]: the chamber's air, wall, machinery and controller.
struct PlantParameters {
  /// Range of accepted set points.
  double lowest_c{};
  double highest_c{};
  /// Air and wall at the start.
  double start_c{};
  /// Temperature around the chamber.
  double room_c{};
  /// Heating rate of the air at 20 °C under full heating, without the wall, and its change per kelvin of air
  /// temperature above 20 °C.
  double heating_k_per_min{};
  double heating_slope_per_min{};
  /// Magnitude of the cooling rate under full cooling, and its change per kelvin.
  double cooling_k_per_min{};
  double cooling_slope_per_min{};
  /// Time constants of the air towards the wall, the wall towards the air, and the wall towards the surroundings.
  double air_by_wall_s{};
  double wall_by_air_s{};
  double wall_by_room_s{};
  /// Lag of heater and cooler behind the controller's output.
  double actuator_s{};
  /// Gain of the controller: output (−1 … 1) per kelvin of error.
  double proportional_per_k{};
  /// Reset time of the controller.
  double integral_time_s{};
  /// The chamber's own air sensor: time constant, standard deviation of its white noise, and resolution.
  double sensor_s{};
  double sensor_noise_k{};
  double sensor_resolution_k{};
  /// Relative humidity of the air around the chamber, and the time constant with which the chamber exchanges its air.
  double room_humidity_percent = 50;
  double air_exchange_s = 14400;
};

/// A conductance between two nodes of the network, by index.
struct ThermalLink {
  std::size_t from{};
  std::size_t to{};
  double w_per_k{};
};

/// [virtual.network]: lumped thermal model of the gyro. The vectors are in the order of `nodes`.
struct NetworkParameters {
  /// Chamber temperature at which the gyro rests at the start.
  double start_c{};
  std::vector<std::string> nodes;
  std::vector<double> capacity_j_per_k;
  std::vector<double> power_w;
  /// Conductance to the node "air", the air inside the cabinet.
  std::vector<double> film_w_per_k;
  /// Conductance to the chamber's air.
  std::vector<double> chamber_w_per_k;
  std::vector<ThermalLink> links;
};

/// [virtual.bias] of the reference simulation. The formula is in lumped_gyro.hpp.
struct LumpedBias {
  /// Factor s of all other terms.
  double scale = 1;
  double linear_deg_per_h_per_k{};      ///< k1
  double quadratic_deg_per_h_per_k2{};  ///< k2
  double wave_deg_per_h{};              ///< u
  double wave_period_k = 55;
  /// Coefficients g of the differences T_A − T_B … T_A − T_H.
  std::array<double, 7> gradient_deg_per_h_per_k{};
  /// Coefficient of the temperature difference between the two discharge arms; 8e-3·m in the reference simulation.
  double arm_deg_per_h_per_k{};
  /// Relative growth of the arm term per kelvin of the block's mean.
  double arm_growth_per_k{};
};

/// body = "reference": the reference simulation's gyro.
struct LumpedGyroParameters {
  NetworkParameters network;
  LumpedBias bias;
};

/// Differences between the left and the right half of a gyro's thermal body. The halves of the finite-element model are
/// equal.
struct UnequalArms {
  /// Left power divided by right power. The sum of left and right is unchanged.
  double gain_left_over_right = 1;
  double ballast_left_over_right = 1;
  /// Conductance from each gain arm along its anode's lead to the cabinet.
  double left_lead_w_per_k{};
  double right_lead_w_per_k{};
};

/// [virtual.bias.ageing]: relative change of coefficients per year, linear in time.
struct Ageing {
  double gas_flow{};
  std::array<double, 4> mirrors{};
  /// Change of the arms' unbalance.
  double gas_balance{};
};

/// [virtual.bias.storage]: storage temperatures of the gyro before a run, as turning points.
struct StorageTemperatures {
  /// Number of turning points before day 0; each later day adds one. If 0, the block has always rested at the start
  /// temperature.
  int turns{};
  double lowest_c{};
  double highest_c{};
};

/// body = "twin": the reduced finite-element gyro, and the physics of its bias.
struct ReducedGyroParameters {
  thermal::ReducedModel model;
  /// Chamber temperature at which the gyro rests at the start.
  double start_c{};
  thermal::GyroFilm film{};
  UnequalArms arms;
  SideWind wind{};
  PowerGrowth power_growth{};
  BiasPhysics bias;
  thermal::ThermalSpread spread;
  /// Sigma of ln of each lead's factor.
  double lead_spread{};
  Ageing ageing{};
  StorageTemperatures storage{};
  /// Starts switched off at air temperature. The first second switches the gyro on.
  bool cold = false;
  /// Seconds between updates of the air conductivity in the gaps.
  int seconds_per_update = 10;
};

/// Limit of `walk_growth`. Within it the angle random walk is positive up to 80 °C.
inline constexpr double kMostWalkGrowth = 0.9;

/// Block temperature at which terms that grow in the cold are specified.
inline constexpr double kColdC = -40;

/// [virtual.gyro.dead_band]: where the dither sags, a rate below the remaining lock-in is lost (gyro_readout.hpp). Off
/// while the half-width is 0.
struct DeadBand {
  /// Half-width with the block at −40 °C. Between `sags_below_c` (half-width 0) and −40 °C it is linear in temperature.
  double half_width_deg_per_h{};
  /// Block temperature below which the dither sags; above −40.
  double sags_below_c{};
};

/// [virtual.gyro]: rotation, noise and read-out (gyro_readout.hpp).
struct ReadoutParameters {
  double arcsec_per_pulse = 1;
  /// Component of the Earth rate along the input axis.
  double earth_rate_deg_per_h{};
  double angle_random_walk_deg_per_sqrt_h{};
  /// First-order Markov drift: standard deviation and correlation time.
  double drift_deg_per_h{};
  double drift_time_s = 3600;
  /// Bias instability: B, and the shortest and the longest correlation time of its processes.
  double instability_deg_per_h{};
  double instability_from_s = 10;
  double instability_to_s = 1e6;
  double rate_random_walk_deg_per_h_per_sqrt_h{};
  /// Constant offset of this gyro.
  double turn_on_deg_per_h{};
  /// Standard deviation of the turn-on offset, which is drawn at each switch-on.
  double turn_on_repeatability_deg_per_h{};
  /// Skew of the gyro's clock; a positive skew runs fast.
  double clock_skew_ppm{};
  /// Relative growth of the angle random walk at −40 °C; at most kMostWalkGrowth.
  double walk_growth{};
  /// Change of the scale factor and tilt of the input axis at 60 °C, relative to 20 °C; linear in temperature.
  double scale_factor_ppm{};
  double tilt_arcmin{};
  /// Component of the Earth rate perpendicular to the input axis, in the direction of the tilt.
  double crosswise_earth_rate_deg_per_h{};
  double lost_pulses_per_h{};
  DeadBand dead_band{};
};

using EachThermometer = std::array<double, 9>;  ///< A…H, shell

/// Failure modes of a thermometer. A dead one is an open input of its instrument.
enum class FailureMode { stuck, offset, spikes, dead };

/// [[virtual.thermometers.failing]]
struct FailingThermometer {
  /// Index of the thermometer of its axis.
  std::size_t index{};
  FailureMode mode{};
  /// Time since the start of the run.
  double from_s{};
  /// Added to every reading (offset), or to single readings with either sign (spikes).
  double error_k{};
  /// Mean rate of spikes.
  double spikes_per_h{};
};

/// [virtual.thermometers]. A value of 0 switches a noise, resolution or lag off.
struct ThermometerParameters {
  /// Standard deviation of the white noise.
  EachThermometer noise_k{};
  EachThermometer resolution_k{};
  EachThermometer time_constant_s{};
  /// Calibration error at 20 °C.
  EachThermometer offset_k{};
  /// Relative calibration error, zero at 20 °C.
  EachThermometer gain{};
  /// Random walk since the calibration.
  EachThermometer drift_k_per_sqrt_day{};
  /// Age of the calibration at the start of a run on day 0.
  double days_since_calibration{};
  /// If true, the drift before a run is fixed by the gyro's seed; otherwise each run draws its own.
  bool drift_by_calendar = false;
  /// Self-heating at 20 °C.
  EachThermometer self_heating_k{};
  std::vector<FailingThermometer> failing{};
};

/// [virtual.spread.hard]: spread of the parameters that only a hard rig has, for gyros of seeds other than 0.
struct HardSpread {
  /// Sigma of ln of each amplitude's factor. Its sign is drawn too.
  double amplitude{};
  /// Standard deviation of each γ, which replaces the file's value.
  double growth{};
  /// Standard deviation of each coefficient's ageing, which replaces the file's value.
  double ageing_per_year{};
};

/// [virtual.spread]: difference between the gyros of seeds other than 0 and the gyro of the file. Factors are
/// log-normal; sigma is the standard deviation of their logarithm.
struct SpreadParameters {
  /// Reference simulation: sigma of each heat capacity and of each film.
  double capacity{};
  double film{};
  /// Sigma of each bias coefficient.
  double bias{};
  /// Standard deviation of each thermometer's calibration error and relative gain error.
  double offset_k{};
  double gain{};
  /// Sigma of each thermometer's time constant.
  double time_constant{};
  /// Standard deviation of the gyro's constant offset.
  double turn_on_deg_per_h{};
  std::optional<HardSpread> hard{};
};

/// A step of an axis' output that does not depend on temperature.
struct OutputHop {
  /// Time since the start of the run.
  double at_s{};
  double deg_per_h{};
  /// Duration; if empty, the step is permanent.
  std::optional<double> for_s{};
};

/// [[virtual.unit.axis]]: parameters of one axis. All other parameters are drawn for each axis; the [virtual] table is
/// the type from which they are drawn.
struct AxisParameters {
  /// Empty only for the single axis of a unit.
  std::string name{};
  double earth_rate_deg_per_h{};
  /// See ReadoutParameters.
  double crosswise_earth_rate_deg_per_h{};
  std::optional<OutputHop> hop{};
  std::vector<FailingThermometer> failing{};
};

/// [[virtual.unit]]
struct UnitParameters {
  std::string name;
  std::vector<AxisParameters> axes;
};

/// [virtual.own_temperature]: a sensor inside each unit that follows the mean block temperature of the first axis.
struct OwnThermometer {
  double time_constant_s = 1;  ///< 1 or more
  /// Standard deviation of the white noise.
  double noise_k{};
  /// 0: unlimited.
  double resolution_k{};
  /// Equal for the sensors of all units.
  double offset_k{};
};

/// [[virtual.value]]: a value that each unit reports in addition to its rate. It is linear in the mean block
/// temperature of the first axis.
struct OwnValue {
  std::string name;
  double at_20_c{};
  double per_k{};
  /// Standard deviation of the white noise.
  double noise{};
};

/// [[virtual.load]]: the load that a unit is to its power supply, a resistor. It is linear in the mean block
/// temperature of the first axis.
struct LoadParameters {
  std::string unit;
  double ohm_at_20_c{};
  /// Relative change per kelvin.
  double per_k{};
};

struct LaboratoryParameters {
  PlantParameters plant;
  std::variant<LumpedGyroParameters, ReducedGyroParameters> body;
  ReadoutParameters gyro;
  ThermometerParameters thermometers;
  SpreadParameters spread;
  /// True if the run starts with chamber and gyro at rest at the profile's first set point.
  bool soaked = false;
  /// If empty, the laboratory has one gyro with the parameters above.
  std::vector<UnitParameters> units{};
  std::vector<BracketParameters> brackets{};
  std::optional<OwnThermometer> own_temperature{};
  std::vector<OwnValue> values{};
  std::vector<LoadParameters> loads{};
};

}  // namespace gyrotherm::simulator
