// SPDX-License-Identifier: Apache-2.0
/// Every number of the virtual laboratory, as the [virtual] table of a rig file gives it.
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
  double lowest_c{};  ///< set points it accepts
  double highest_c{};
  double start_c{};                ///< air and wall at the start
  double room_c{};                 ///< around the chamber
  double heating_k_per_min{};      ///< of the air at 20 °C under full heating, before the wall takes its share
  double heating_slope_per_min{};  ///< change of that per kelvin of air temperature above 20 °C
  double cooling_k_per_min{};      ///< likewise under full cooling, a magnitude
  double cooling_slope_per_min{};
  double air_by_wall_s{};       ///< time constant with which the wall pulls the air
  double wall_by_air_s{};       ///< and the air the wall
  double wall_by_room_s{};      ///< and the room the wall
  double actuator_s{};          ///< lag of heater and cooler behind the controller's output
  double proportional_per_k{};  ///< controller: output (−1…1) per kelvin of error
  double integral_time_s{};     ///< controller: reset time
  double sensor_s{};            ///< time constant of the chamber's own air sensor
  double sensor_noise_k{};      ///< standard deviation, white
  double sensor_resolution_k{};
};

/// A conductance between two nodes of the network, by index.
struct ThermalLink {
  std::size_t from{};
  std::size_t to{};
  double w_per_k{};
};

/// [virtual.network]: lumped thermal model of the gyro; the vectors are in the order of `nodes`.
struct NetworkParameters {
  double start_c{};  ///< chamber temperature at which the gyro rests at the start
  std::vector<std::string> nodes;
  std::vector<double> capacity_j_per_k;
  std::vector<double> power_w;
  std::vector<double> film_w_per_k;     ///< to the node "air", the air inside the cabinet
  std::vector<double> chamber_w_per_k;  ///< to the chamber's air
  std::vector<ThermalLink> links;       ///< by conduction
};

/// [virtual.bias] of the reference simulation (lumped_gyro.hpp has the formula).
struct LumpedBias {
  double scale = 1;                     ///< s, of everything below
  double linear_deg_per_h_per_k{};      ///< k1
  double quadratic_deg_per_h_per_k2{};  ///< k2
  double wave_deg_per_h{};              ///< u
  double wave_period_k = 55;
  std::array<double, 7> gradient_deg_per_h_per_k{};  ///< g of T_A − T_B … T_A − T_H
  double arm_deg_per_h_per_k{};  ///< 8e-3·m, of the temperature difference of the two discharge arms
  double arm_growth_per_k{};     ///< relative growth of the arm term per kelvin of mean block temperature
};

/// body = "reference": the reference simulation's gyro.
struct LumpedGyroParameters {
  NetworkParameters network;
  LumpedBias bias;
};

/// How the left and the right half of a gyro's thermal body differ; the finite elements make them alike.
struct UnequalArms {
  double gain_left_over_right = 1;  ///< power; the sum is kept
  double ballast_left_over_right = 1;
  double left_lead_w_per_k{};  ///< conduction from the gain arm along its anode's lead to the cabinet
  double right_lead_w_per_k{};
};

/// [virtual.bias.ageing]: relative change of coefficients in a year, each along a straight line.
struct Ageing {
  double gas_flow{};
  std::array<double, 4> mirrors{};
  double gas_balance{};  ///< of the arms' unbalance
};

/// [virtual.bias.storage]: where the gyro was before a run, from turn to turn.
struct Storage {
  int turns{};  ///< between the gyro's making and day 0; from then on one a day. 0: it has always rested at the start
  double lowest_c{};
  double highest_c{};
};

/// body = "twin": the finite-element gyro, reduced, and the physics of its bias.
struct ReducedGyroParameters {
  thermal::ReducedModel model;
  double start_c{};  ///< chamber temperature at which the gyro rests at the start
  thermal::GyroFilm film{};
  UnequalArms arms;
  SideWind wind{};
  PowerGrowth power_growth{};
  BiasPhysics bias;
  thermal::ThermalSpread spread;
  double lead_spread{};  ///< sigma of ln of each lead's factor
  Ageing ageing{};
  Storage storage{};
  bool cold = false;            ///< starts switched off, as warm as the air, and is switched on with its first second
  int seconds_per_update = 10;  ///< of the conductivity of its gaps' air
};

/// So that the angle random walk is above 0 up to 80 °C.
inline constexpr double kMostWalkGrowth = 0.9;

/// Temperature of the block at which a term that grows in the cold is given.
inline constexpr double kColdC = -40;

/// [virtual.gyro.dead_band]: where the dither sags, a rate below the residual lock-in is lost (gyro_readout.hpp). Off
/// while the half-width is 0.
struct DeadBand {
  double half_width_deg_per_h{};  ///< with the block at −40 °C, along a straight line from 0 where the dither sags
  double sags_below_c{};          ///< of the block; above −40
};

/// [virtual.gyro]: rotation, noise and read-out (gyro_readout.hpp).
struct ReadoutParameters {
  double arcsec_per_pulse = 1;
  double earth_rate_deg_per_h{};  ///< on the input axis
  double angle_random_walk_deg_per_sqrt_h{};
  double drift_deg_per_h{};        ///< standard deviation of the first-order Markov drift
  double drift_time_s = 3600;      ///< its correlation time
  double instability_deg_per_h{};  ///< B of the bias instability, from instability_from_s on
  double instability_from_s = 10;  ///< shortest correlation time of its processes
  double instability_to_s = 1e6;   ///< and the longest
  double rate_random_walk_deg_per_h_per_sqrt_h{};
  double turn_on_deg_per_h{};                ///< constant offset of this gyro
  double turn_on_repeatability_deg_per_h{};  ///< standard deviation from turn-on to turn-on: drawn for each run
  double clock_skew_ppm{};                   ///< of the gyro's clock; positive runs fast
  double walk_growth{};       ///< of the angle random walk at −40 °C, relative; at most kMostWalkGrowth
  double scale_factor_ppm{};  ///< at 60 °C, relative to 20 °C, likewise
  double tilt_arcmin{};       ///< of the input axis, likewise
  double crosswise_earth_rate_deg_per_h{};  ///< at right angles to the input axis, the way that it tilts
  double lost_pulses_per_h{};
  DeadBand dead_band{};
};

using EachThermometer = std::array<double, 9>;  ///< A…H, shell

/// How a thermometer fails; a dead one is an open input of its instrument.
enum class Failing { stuck, offset, spikes, dead };

/// [[virtual.thermometers.failing]]
struct FailingThermometer {
  std::size_t place{};
  Failing how{};
  double from_s{};        ///< of the run
  double error_k{};       ///< offset: added; spikes: added to single readings, either way
  double spikes_per_h{};  ///< on average
};

/// [virtual.thermometers]
struct ThermometerParameters {
  EachThermometer noise_k{};               ///< standard deviation, white
  EachThermometer resolution_k{};          ///< 0: none
  EachThermometer time_constant_s{};       ///< 0: none
  EachThermometer offset_k{};              ///< calibration error at 20 °C
  EachThermometer gain{};                  ///< calibration error, relative, about 20 °C
  EachThermometer drift_k_per_sqrt_day{};  ///< random walk since the calibration
  double days_since_calibration{};         ///< at the start of each run of day 0
  bool drift_by_calendar = false;          ///< until a run starts the drift is the thermometer's own, else each run's
  EachThermometer self_heating_k{};        ///< at 20 °C
  std::vector<FailingThermometer> failing{};
};

/// [virtual.spread.hard]: how the gyros of other seeds differ in what only a hard rig has.
struct HardSpread {
  double amplitude{};        ///< sigma of ln of each amplitude's factor, whose sign is drawn too
  double growth{};           ///< standard deviation of each γ, drawn anew
  double ageing_per_year{};  ///< … of each coefficient's ageing, likewise
};

/// [virtual.spread]: how much the gyros of seeds other than 0 differ from the one of the file. Factors are log-normal.
struct SpreadParameters {
  double capacity{};           ///< reference: sigma of ln of each heat capacity's factor
  double film{};               ///< reference: … of each film's
  double bias{};               ///< … of each bias coefficient's
  double offset_k{};           ///< standard deviation of each thermometer's calibration error
  double gain{};               ///< … of each thermometer's relative error of gain
  double time_constant{};      ///< sigma of ln of each thermometer's time constant's factor
  double turn_on_deg_per_h{};  ///< standard deviation of the gyro's constant offset
  std::optional<HardSpread> hard{};
};

/// A step of an axis' output of which no temperature tells.
struct OutputHop {
  double at_s{};  ///< of the run
  double deg_per_h{};
  std::optional<double> for_s{};  ///< nothing: it stays
};

/// [[virtual.unit.axis]]: what one axis has of its own. All else is the type's, drawn anew for each.
struct AxisParameters {
  std::string name{};  ///< "" only of a unit's one axis
  double earth_rate_deg_per_h{};
  double crosswise_earth_rate_deg_per_h{};  ///< as ReadoutParameters has it
  std::optional<OutputHop> hop{};
  std::vector<FailingThermometer> failing{};
};

/// [[virtual.unit]]
struct UnitParameters {
  std::string name;
  std::vector<AxisParameters> axes;  ///< at least one
};

/// [virtual.own_temperature]: a sensor inside each unit, which follows the mean of its first axis' block.
struct OwnThermometer {
  double time_constant_s = 1;  ///< 1 or more
  double noise_k{};            ///< standard deviation, white
  double resolution_k{};       ///< 0: none
  double offset_k{};           ///< of the sensor in each unit alike
};

/// [[virtual.value]]: a number beside its rate that each unit tells of itself, a straight line in the mean of its first
/// axis' block.
struct OwnValue {
  std::string name;
  double at_20_c{};
  double per_k{};
  double noise{};  ///< standard deviation, white
};

struct LaboratoryParameters {
  PlantParameters plant;
  std::variant<LumpedGyroParameters, ReducedGyroParameters> body;
  ReadoutParameters gyro;
  ThermometerParameters thermometers;
  SpreadParameters spread;
  bool soaked = false;  ///< before a run, chamber and gyro have stood at the profile's first set point for long
  std::vector<UnitParameters> units{};  ///< none: the plain world, one gyro with the numbers of the type
  std::vector<BracketParameters> brackets{};
  std::optional<OwnThermometer> own_temperature{};
  std::vector<OwnValue> values{};
};

}  // namespace gyrotherm::simulator
