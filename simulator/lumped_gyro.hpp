// SPDX-License-Identifier: Apache-2.0
/// The gyro of the reference simulation: a lumped thermal network, and a bias that depends on its present temperatures
/// only.
#pragma once

#include <Eigen/Core>
#include <array>

#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm::simulator {

/// dT/dt = rates·T + chamber·T_chamber + heating, in 1/s, 1/s and K/s.
struct NetworkEquations {
  Eigen::MatrixXd rates;
  Eigen::VectorXd chamber;
  Eigen::VectorXd heating;
};

[[nodiscard]] NetworkEquations make_equations(const NetworkParameters& network);

/// Returns the temperatures of the network at rest in chamber air of `air`.
[[nodiscard]] Eigen::VectorXd rest_temperatures(const NetworkEquations& equations, Celsius air);

class ThermalNetwork final {
 public:
  /// Starts at rest at the network's start temperature. `network` must contain the nodes A…H and "air", and each node
  /// must be connected to the chamber (parse_laboratory checks both).
  explicit ThermalNetwork(const NetworkParameters& network);

  void step(Celsius air);
  void switch_on(bool on) { on_ = on; }
  [[nodiscard]] LocationTemperatures temperatures_c() const { return locations_c_; }

 private:
  void publish();

  Eigen::MatrixXd transition_;  ///< 1 + rates·1 s
  Eigen::VectorXd chamber_;     ///< times 1 s
  Eigen::VectorXd heating_k_;
  bool on_ = true;
  Eigen::VectorXd state_c_;
  Eigen::VectorXd next_c_;
  std::array<Eigen::Index, kThermalLocations> location_nodes_{};
  std::array<double, kThermalLocations> locations_c_{};
};

/// Returns the bias of the reference simulation: b = s·{ k1·x + k2·x² + Σ_{X=B…H} g_X (T_A − T_X) + arm·(T_B + T_D −
/// T_C − T_E)/2·(1 + growth·x) + u·sin(2πx/period) }, x = block mean − 20 °C. The terms with k1, k2 and u depend only
/// on the block mean, so temperature differences do not contain them. The gradient terms are linear. The arm term
/// represents the unequal gas flow of the two discharge arms, which grows with temperature.
[[nodiscard]] DegreesPerHour reference_bias(const LumpedBias& bias, BlockTemperatures block_c);

class LumpedGyro final : public VirtualGyro {
 public:
  /// Starts at rest at the network's start temperature. The preconditions of ThermalNetwork apply.
  explicit LumpedGyro(const LumpedGyroParameters& parameters)
      : bias_parameters_(parameters.bias), network_(parameters.network) {}

  void step(Celsius air, double /*output*/) override { network_.step(air); }
  void switch_on(bool on) override { network_.switch_on(on); }
  [[nodiscard]] LocationTemperatures locations_c() const override { return network_.temperatures_c(); }
  [[nodiscard]] DegreesPerHour bias() const override {
    return reference_bias(bias_parameters_, locations_c().first<kBlockLocations>());
  }
  [[nodiscard]] Celsius block() const override;

 private:
  LumpedBias bias_parameters_;
  ThermalNetwork network_;
};

}  // namespace gyrotherm::simulator
