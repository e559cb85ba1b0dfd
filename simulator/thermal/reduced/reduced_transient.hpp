// SPDX-License-Identifier: Apache-2.0
/// The working gyro as a thermal body, one second at a time: the reduced finite-element model with the conductivity of
/// its air following its temperature.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <variant>

#include "core/quantity.hpp"
#include "simulator/thermal/reduced/reduced_model.hpp"

namespace gyrotherm::thermal {

/// K(c) = Q Λ Qᵀ.
struct ThermalModes {
  Eigen::VectorXd rates_per_s;  ///< Λ > 0, ascending
  Eigen::MatrixXd shapes;       ///< Q, orthogonal: x = Q m for the amplitudes m of the modes
};

[[nodiscard]] ThermalModes modes_of(const ReducedModel& model, const ThermalCoefficients& c);

/// Per mode, exact for an input that goes linearly from u to u⁺ within a step h (first-order hold):
///   m⁺ = decay m + before u + after u⁺.
/// With z = λh: decay = e^−z, before + after = (1 − e^−z)/λ, after = (1 − (1 − e^−z)/z)/λ.
struct ModalWeights {
  Eigen::ArrayXd decay, before, after;
};

[[nodiscard]] ModalWeights modal_weights(const Eigen::VectorXd& rates_per_s, double step_s);

/// One second with the model's powers on, in the basis of the states: x⁺ = carry x + before T + after T⁺ + powers,
/// T in °C of the air outside; and per_watt w of powers w above them, constant in that second.
struct OneSecond {
  Eigen::MatrixXd carry;  ///< symmetric
  Eigen::VectorXd before, after, powers;
  Eigen::MatrixXd per_watt{};  ///< one column per power
};

[[nodiscard]] OneSecond one_second(const ReducedModel& model, const ThermalCoefficients& c);

/// One second in the basis of the modes, for constant coefficients: a⁺ = decay a + before T + after T⁺ + powers, and
/// per_watt w.
struct ModalSecond {
  Eigen::MatrixXd shapes;
  Eigen::ArrayXd decay, before, after, powers;
  Eigen::MatrixXd per_watt;

  ModalSecond(const ReducedModel& model, const ThermalCoefficients& c);
  /// `added_w`: above the model's powers, all of them; empty: none. `on`: the model's own.
  void step(Eigen::VectorXd& amplitudes, double from_c, double to_c, std::span<const double> added_w = {},
            bool on = true) const;
};

class StepTable final {
 public:
  /// `powers_vary`: steps may be told powers above the model's.
  StepTable(const ReducedModel& model, GyroFilm film, bool powers_vary = false);

  /// The step in force from now on; temperatures beyond the table count as its ends.
  void update(double air_c);
  /// One second while the air outside goes from one temperature to the other; update() must have been called.
  /// `added_w`: above the model's powers, all of them, or empty. `on`: the model's own.
  void step(Eigen::VectorXd& states, double from_c, double to_c, std::span<const double> added_w = {}, bool on = true);

 private:
  Eigen::VectorXd nodes_c_;
  Eigen::VectorXd weights_;  ///< barycentric
  Eigen::MatrixXd table_;    ///< one column per node: carry, before, after, powers, and per_watt if these vary
  Eigen::VectorXd now_;      ///< likewise, at the temperature of the update
  Eigen::VectorXd next_;
};

struct ReducedTransientOptions {
  Celsius start{20};  ///< air at which the gyro, switched on, rests at the start
  bool cold = false;  ///< it rests there switched off, and is switched on with the first second
  GyroFilm film = GyroFilm::chamber;
  /// Above the model's powers at the start; nothing: they are the model's all the time.
  std::optional<ThermalPowers> added_w{};
  bool linear = false;          ///< keep the air's conductivity of the start
  int seconds_per_update = 10;  ///< of the air's conductivity
};

/// Where the gyro, switched on, rests in air of `air_c`: states, with the gaps at the mean of block and shell.
[[nodiscard]] Eigen::VectorXd rest_of(const ReducedModel& model, GyroFilm film, double air_c);

/// The model with so much added to its powers.
[[nodiscard]] ReducedModel with_added(ReducedModel model, const ThermalPowers& added_w);

/// Where it rests switched off: everything as warm as the air.
[[nodiscard]] Eigen::VectorXd cold_rest_of(const ReducedModel& model, GyroFilm film, double air_c);

/// The temperature of the air in the gaps: the mean of block and shell.
[[nodiscard]] double gap_air_c(const Eigen::Ref<const Eigen::VectorXd>& outputs_c);

class ReducedTransient final {
 public:
  ReducedTransient(const ReducedModel& model, const ReducedTransientOptions& options);

  /// Lets one second pass while the chamber's air goes linearly from where it was to `air`; exact for that input and
  /// constant coefficients. `added_w`: above the model's powers in that second, only where the options have them.
  void step(Celsius air, std::span<const double> added_w = {});
  /// The model's own powers, from the next second on.
  void switch_on(bool on) { on_ = on; }

  /// In the order of ThermalOutput, °C.
  [[nodiscard]] std::span<const double, kThermalOutputs> outputs_c() const;

 private:
  /// With constant coefficients the states become amplitudes of modes.
  std::variant<ModalSecond, StepTable> law_of(const ReducedModel& model);

  ReducedTransientOptions options_;
  double air_c_;
  long seconds_ = 0;
  bool on_ = true;
  Eigen::VectorXd states_;
  Eigen::MatrixXd outputs_;  ///< of the states as the law keeps them
  std::variant<ModalSecond, StepTable> law_;
  Eigen::Vector<double, kThermalOutputs> outputs_c_;
};

}  // namespace gyrotherm::thermal
