// SPDX-License-Identifier: Apache-2.0
/// The gyro as the virtual laboratory needs it: a body in the chamber's air, with true temperatures and a true bias.
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

inline constexpr std::size_t kBlockPlaces = 8;    ///< A…H, on the block
inline constexpr std::size_t kThermalPlaces = 9;  ///< and "shell": the cabinet's, or the air in it

/// The names of the places, in their order everywhere in this room.
inline constexpr std::array<std::string_view, kThermalPlaces> kPlaceNames{"A", "B", "C", "D",    "E",
                                                                          "F", "G", "H", "shell"};

using BlockTemperatures = std::span<const double, kBlockPlaces>;    ///< °C
using PlaceTemperatures = std::span<const double, kThermalPlaces>;  ///< °C

class VirtualGyro {
 public:
  virtual ~VirtualGyro() = default;
  /// Lets one second pass with the chamber's air at `air`, while heater (positive) and cooler (negative) give `output`,
  /// −1 … 1, of what they can: the side from which the air blows may follow it.
  virtual void step(Celsius air, double output) = 0;
  /// Its power; without, it warms nothing, and its warm-up begins when it is switched on again.
  virtual void switch_on(bool on) = 0;
  /// True temperatures at the places now: what the thermometers are at.
  [[nodiscard]] virtual PlaceTemperatures places_c() const = 0;
  /// What its temperatures, now and before, and its warm-up make of its bias; without noise, turn-on and rotation.
  [[nodiscard]] virtual DegreesPerHour bias() const = 0;
  /// The mean of its block.
  [[nodiscard]] virtual Celsius block() const = 0;
};

// The finite-element gyro, reduced, with the physics of its bias: what the default virtual rig stands on.

/// The model with its left and right half made unequal: powers shared anew, and for each lead, of conductance g from
/// gain arm to shell, K₀ + g (l − s)(l − s)ᵀ, l and s their rows of the outputs: heat leaves the arm as evenly as its
/// own power enters it. Symmetric positive definite stays so.
[[nodiscard]] thermal::ReducedModel with_unequal_arms(thermal::ReducedModel model, const UnequalArms& arms);

/// The thermometers see A…H and the shell; the bias sees the twin's gain arms, mirrors and block alone.
class ReducedGyro final : public VirtualGyro {
 public:
  /// Starts at rest, switched on (a cold one: switched off until now), in air at the parameters' start temperature.
  explicit ReducedGyro(const ReducedGyroParameters& parameters, const GyroPast& past = {});

  void step(Celsius air, double output) override;
  void switch_on(bool on) override;
  [[nodiscard]] PlaceTemperatures places_c() const override { return reduced_.outputs_c().first<kThermalPlaces>(); }
  [[nodiscard]] DegreesPerHour bias() const override { return bias_.total(); }
  [[nodiscard]] Celsius block() const override {
    return {inner_c()[static_cast<std::size_t>(thermal::ThermalOutput::block)]};
  }

  [[nodiscard]] const BiasParts& bias_parts() const { return bias_.parts(); }
  [[nodiscard]] InnerTemperatures inner_c() const { return reduced_.outputs_c(); }

 private:
  ReducedGyro(const thermal::ReducedModel& model, const ReducedGyroParameters& parameters, const GyroPast& past);

  AddedHeat heat_;
  thermal::ReducedTransient reduced_;
  GyroBias bias_;
};

/// Where its cabinet rests in air at the parameters' start temperature: switched off, if it is a cold one.
[[nodiscard]] Celsius cabinet_at_rest(const ReducedGyroParameters& parameters);

}  // namespace gyrotherm::simulator
