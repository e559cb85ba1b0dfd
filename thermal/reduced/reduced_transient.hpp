/// The working gyro as a thermal body, one second at a time: the reduced finite-element model with the conductivity of
/// its air following its temperature.
#pragma once

#include <array>
#include <memory>
#include <span>

#include "core/quantity.hpp"
#include "thermal/reduced/reduced_model.hpp"

namespace gyrotherm {

struct ReducedTransientOptions {
  Celsius start{20};  ///< air at which the gyro, switched on, rests at the start
  GyroFilm film = GyroFilm::chamber;
  bool linear = false;          ///< keep the air's conductivity of the start
  int seconds_per_update = 10;  ///< of the air's conductivity
};

/// Where the gyro, switched on, rests in air of `air_c`: states, with the gaps at the mean of block and shell.
[[nodiscard]] Eigen::VectorXd rest_of(const ReducedModel& model, GyroFilm film, double air_c);

/// The temperature of the air in the gaps: the mean of block and shell.
[[nodiscard]] double gap_air_c(const Eigen::Ref<const Eigen::VectorXd>& outputs_c);

class ReducedTransient final {
 public:
  ReducedTransient(const ReducedModel& model, const ReducedTransientOptions& options);
  ~ReducedTransient();
  ReducedTransient(ReducedTransient&&) noexcept;
  ReducedTransient& operator=(ReducedTransient&&) noexcept;

  /// Lets one second pass while the chamber's air goes linearly from where it was to `air`; exact for that input and
  /// constant coefficients.
  void step(Celsius air);

  /// In the order of ThermalOutput, °C.
  [[nodiscard]] std::span<const double, kThermalOutputs> outputs_c() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gyrotherm
