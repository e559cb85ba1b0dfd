/// Every number of the virtual laboratory, as the [virtual] table of a rig file gives it.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace gyrotherm {

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

/// [virtual.bias]: the gyro's bias as a function of its temperatures (gyro_bias.hpp has the formula).
struct BiasParameters {
  double scale = 1;                     ///< s, of everything below
  double linear_deg_per_h_per_k{};      ///< k1
  double quadratic_deg_per_h_per_k2{};  ///< k2
  double wave_deg_per_h{};              ///< u
  double wave_period_k = 55;
  std::array<double, 7> gradient_deg_per_h_per_k{};  ///< g of T_A − T_B … T_A − T_H
  double arm_deg_per_h_per_k{};  ///< 8e-3·m, of the temperature difference of the two discharge arms
  double arm_growth_per_k{};     ///< relative growth of the arm term per kelvin of mean block temperature
};

/// [virtual.gyro]: rotation, noise and read-out.
struct ReadoutParameters {
  double arcsec_per_pulse = 1;
  double earth_rate_deg_per_h{};  ///< on the input axis
  double angle_random_walk_deg_per_sqrt_h{};
  double drift_deg_per_h{};    ///< standard deviation of the first-order Markov drift
  double drift_time_s = 3600;  ///< its correlation time
  double turn_on_deg_per_h{};  ///< constant offset of this turn-on
  double clock_skew_ppm{};     ///< of the gyro's clock; positive runs fast
};

/// [virtual.thermometers]: A…H and "shell" alike.
struct ThermometerParameters {
  double noise_k{};  ///< standard deviation, white
  double resolution_k{};
  double time_constant_s{};          ///< 0: none
  std::array<double, 9> offset_k{};  ///< calibration error of A…H, shell
};

/// [virtual.spread]: how much the gyros of seeds other than 0 differ from the one of the file. Factors are log-normal.
struct SpreadParameters {
  double capacity{};           ///< sigma of ln of each heat capacity's factor
  double film{};               ///< … of each film's
  double bias{};               ///< … of each bias coefficient's
  double offset_k{};           ///< standard deviation of each thermometer's calibration error
  double turn_on_deg_per_h{};  ///< standard deviation of the turn-on offset
};

struct WorldParameters {
  PlantParameters plant;
  NetworkParameters network;
  BiasParameters bias;
  ReadoutParameters gyro;
  ThermometerParameters thermometers;
  SpreadParameters spread;
};

}  // namespace gyrotherm
