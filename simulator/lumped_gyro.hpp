/// The gyro of the reference simulation: a lumped thermal network, and a bias that is a function of its temperatures
/// alone.
#pragma once

#include "simulator/laboratory_parameters.hpp"
#include "simulator/thermal_network.hpp"
#include "simulator/virtual_gyro.hpp"

namespace gyrotherm {

/// The mean of A…H.
[[nodiscard]] double block_mean_c(BlockTemperatures block_c);

/// b = s·{ k1·x + k2·x² + Σ_{X=B…H} g_X (T_A − T_X) + arm·(T_B + T_D − T_C − T_E)/2·(1 + growth·x) + u·sin(2πx/period)
/// }, x = block mean − 20 °C. The reference simulation's law: a temperature part no gradient can see (k1, k2, u), a
/// part linear in the gradients, and the unequal gas flow of the two discharge arms, which grows with temperature.
[[nodiscard]] DegreesPerHour reference_bias(const LumpedBias& bias, BlockTemperatures block_c);

class LumpedGyro final : public VirtualGyro {
 public:
  /// Starts at rest at the network's start temperature. The network's terms are those of ThermalNetwork.
  explicit LumpedGyro(const LumpedGyroParameters& parameters) : law_(parameters.bias), network_(parameters.network) {}

  void step(Celsius air) override { network_.step(air); }
  [[nodiscard]] PlaceTemperatures places_c() const override { return network_.temperatures_c(); }
  [[nodiscard]] DegreesPerHour bias() const override { return reference_bias(law_, places_c().first<kBlockPlaces>()); }

 private:
  LumpedBias law_;
  ThermalNetwork network_;
};

}  // namespace gyrotherm
