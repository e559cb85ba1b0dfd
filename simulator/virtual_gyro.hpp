// SPDX-License-Identifier: Apache-2.0
/// The interface of a gyro in the virtual laboratory: a body in the chamber's air, with true temperatures and a true
/// bias.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "core/quantity.hpp"
#include "simulator/gyro_bias.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/thermal/reduced/reduced_transient.hpp"

namespace gyrotherm::simulator {

/// Number of locations on the block (A…H), and their number with "shell", the cabinet or the air in it.
inline constexpr std::size_t kBlockLocations = 8;
inline constexpr std::size_t kThermalLocations = 9;

/// Names of the thermal locations, in the order that all simulator interfaces use.
inline constexpr std::array<std::string_view, kThermalLocations> kLocationNames{"A", "B", "C", "D",    "E",
                                                                                "F", "G", "H", "shell"};

using BlockTemperatures = std::span<const double, kBlockLocations>;       ///< °C
using LocationTemperatures = std::span<const double, kThermalLocations>;  ///< °C

class VirtualGyro {
 public:
  virtual ~VirtualGyro() = default;
  /// Advances by one second. `air` is the chamber's air, `output` the output of heater (positive) and cooler
  /// (negative), −1 … 1; the direction of the air stream may depend on it.
  virtual void step(Celsius air, double output) = 0;
  /// Switches the gyro's power. A gyro without power produces no heat. Its warm-up begins when it is switched on again.
  virtual void switch_on(bool on) = 0;
  /// Returns the present true temperatures of the locations, without the thermometers' errors.
  [[nodiscard]] virtual LocationTemperatures locations_c() const = 0;
  /// Returns the bias caused by present and past temperatures and by the warm-up, without noise, turn-on offset and
  /// rotation.
  [[nodiscard]] virtual DegreesPerHour bias() const = 0;
  /// Returns the mean temperature of the block.
  [[nodiscard]] virtual Celsius block() const = 0;
};

// The reduced finite-element gyro with the physics of its bias. The default virtual rig uses it.

/// Returns the model with unequal halves: redistributed powers, and for each lead, with conductance g from gain arm to
/// shell, K₀ + g (l − s)(l − s)ᵀ, where l and s are the output rows of arm and shell. Heat leaves the arm with the same
/// spatial distribution as its own power. A symmetric positive definite K₀ remains so.
[[nodiscard]] thermal::ReducedModel apply_unequal_arms(thermal::ReducedModel model, const UnequalArms& arms);

/// The reduced gyro. The thermometers measure A…H and the shell; the bias depends only on gain arms, mirrors and block.
class ReducedGyro final : public VirtualGyro {
 public:
  /// Starts at rest in air at the parameters' start temperature. A cold gyro starts switched off, any other switched
  /// on.
  explicit ReducedGyro(const ReducedGyroParameters& parameters, const GyroHistory& past = {});

  void step(Celsius air, double output) override;
  void switch_on(bool on) override;
  [[nodiscard]] LocationTemperatures locations_c() const override {
    return reduced_.outputs_c().first<kThermalLocations>();
  }
  [[nodiscard]] DegreesPerHour bias() const override { return bias_.total(); }
  [[nodiscard]] Celsius block() const override {
    return {inner_c()[static_cast<std::size_t>(thermal::ThermalOutput::block)]};
  }

  [[nodiscard]] const BiasParts& bias_parts() const { return bias_.parts(); }
  [[nodiscard]] InnerTemperatures inner_c() const { return reduced_.outputs_c(); }

 private:
  ReducedGyro(const thermal::ReducedModel& model, const ReducedGyroParameters& parameters, const GyroHistory& past);

  AddedHeat heat_;
  thermal::ReducedTransient reduced_;
  GyroBias bias_;
};

/// Returns the temperature of the cabinet at rest in air at the parameters' start temperature. A cold gyro is switched
/// off.
[[nodiscard]] Celsius cabinet_at_rest(const ReducedGyroParameters& parameters);

}  // namespace gyrotherm::simulator
