/// The gyro as a network of lumped heat capacities, one of them the air inside the cabinet:
/// C_i dT_i/dt = Σ_j G_ij (T_j − T_i) + G_i,chamber (T_chamber − T_i) + P_i, explicit Euler, 1 s.
#pragma once

#include <Eigen/Core>
#include <array>

#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm {

/// dT/dt = rates·T + chamber·T_chamber + heating, in 1/s, 1/s and K/s.
struct NetworkEquations {
  Eigen::MatrixXd rates;
  Eigen::VectorXd chamber;
  Eigen::VectorXd heating;
};

[[nodiscard]] NetworkEquations equations_of(const NetworkParameters& network);

/// Where the network rests when the chamber stays at `air`.
[[nodiscard]] Eigen::VectorXd at_rest(const NetworkEquations& equations, Celsius air);

class ThermalNetwork final {
 public:
  /// Starts at rest at the network's start temperature. `network` must hold the nodes A…H and "air", and every node
  /// must have a way to the chamber (parse_laboratory checks both).
  explicit ThermalNetwork(const NetworkParameters& network);

  void step(Celsius air);
  [[nodiscard]] PlaceTemperatures temperatures_c() const { return places_c_; }

 private:
  void publish();

  Eigen::MatrixXd transition_;  ///< 1 + rates·1 s
  Eigen::VectorXd chamber_;     ///< times 1 s
  Eigen::VectorXd heating_k_;
  Eigen::VectorXd state_c_;
  Eigen::VectorXd next_c_;
  std::array<Eigen::Index, kThermalPlaces> place_nodes_{};
  std::array<double, kThermalPlaces> places_c_{};
};

}  // namespace gyrotherm
