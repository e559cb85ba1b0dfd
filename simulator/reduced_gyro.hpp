/// The finite-element gyro, reduced, with the physics of its bias: what the default virtual rig stands on.
#pragma once

#include <array>

#include "simulator/gyro_bias.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_gyro.hpp"
#include "thermal/reduced/reduced_transient.hpp"

namespace gyrotherm {

/// The model with its left and right half made unequal: powers shared anew, and for each lead, of conductance g from
/// gain arm to shell, K₀ + g (l − s)(l − s)ᵀ, l and s their rows of the outputs: heat leaves the arm as evenly as its
/// own power enters it. Symmetric positive definite stays so.
[[nodiscard]] ReducedModel with_unequal_arms(ReducedModel model, const UnequalArms& arms);

/// The thermometers see A…H and the shell; the bias sees the twin's gain arms, mirrors and block alone.
class ReducedGyro final : public VirtualGyro {
 public:
  /// Starts at rest, switched on, in air at the parameters' start temperature.
  explicit ReducedGyro(const ReducedGyroParameters& parameters);

  void step(Celsius air) override;
  [[nodiscard]] PlaceTemperatures places_c() const override { return reduced_.outputs_c().first<kThermalPlaces>(); }
  [[nodiscard]] DegreesPerHour bias() const override { return bias_.total(); }

  [[nodiscard]] const BiasParts& bias_parts() const { return bias_.parts(); }
  [[nodiscard]] InnerTemperatures inner_c() const { return reduced_.outputs_c(); }

 private:
  ReducedTransient reduced_;
  GyroBias bias_;
};

}  // namespace gyrotherm
