// SPDX-License-Identifier: Apache-2.0
/// The working gyro as a thermal body, advanced one second at a time: the reduced finite-element model. The
/// conductivity of the gap air follows the temperature of the gap air.
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
  /// Λ > 0, ascending.
  Eigen::VectorXd rates_per_s;
  /// Q, orthogonal: x = Q m for the amplitudes m of the modes.
  Eigen::MatrixXd shapes;
};

[[nodiscard]] ThermalModes compute_modes(const ReducedModel& model, const ThermalCoefficients& c);

/// Weights per mode, exact for an input that changes linearly from u to u⁺ within a step h (first-order hold):
///   m⁺ = decay m + before u + after u⁺.
/// With z = λh: decay = e^−z, before + after = (1 − e^−z)/λ, after = (1 − (1 − e^−z)/z)/λ.
struct ModalWeights {
  Eigen::ArrayXd decay, before, after;
};

[[nodiscard]] ModalWeights modal_weights(const Eigen::VectorXd& rates_per_s, double step_s);

/// One second with the model's powers on, in the basis of the states: x⁺ = carry x + before T + after T⁺ + powers +
/// per_watt w. T is the outside air in °C; w are additional powers, constant during the second.
struct OneSecond {
  Eigen::MatrixXd carry;
  Eigen::VectorXd before, after, powers;
  Eigen::MatrixXd per_watt{};
};

[[nodiscard]] OneSecond one_second(const ReducedModel& model, const ThermalCoefficients& c);

/// One second in the basis of the modes, for constant coefficients: a⁺ = decay a + before T + after T⁺ + powers +
/// per_watt w.
struct ModalSecond {
  Eigen::MatrixXd shapes;
  Eigen::ArrayXd decay, before, after, powers;
  Eigen::MatrixXd per_watt;

  ModalSecond(const ReducedModel& model, const ThermalCoefficients& c);
  /// Advances the amplitudes. `added_w` contains a power for each source, in addition to the model's, or is empty. `on`
  /// switches the model's own powers.
  void step(Eigen::VectorXd& amplitudes, double from_c, double to_c, std::span<const double> added_w = {},
            bool on = true) const;
};

class StepTable final {
 public:
  /// Creates the table. Steps accept additional powers if `powers_vary`.
  StepTable(const ReducedModel& model, GyroFilm film, bool powers_vary = false);

  /// Selects the step for a gap air of `air_c`. Outside the table, the nearer end applies.
  void update(double air_c);
  /// Advances by one second while the outside air changes linearly from `from_c` to `to_c`. Requires update().
  /// `added_w` contains a power for each source, in addition to the model's, or is empty. `on` switches the model's own
  /// powers.
  void step(Eigen::VectorXd& states, double from_c, double to_c, std::span<const double> added_w = {}, bool on = true);

 private:
  Eigen::VectorXd nodes_c_;
  /// Barycentric weights.
  Eigen::VectorXd weights_;
  /// One column per node: carry, before, after, powers, and per_watt if the powers vary.
  Eigen::MatrixXd table_;
  /// Column of the table, interpolated to the temperature of the last update().
  Eigen::VectorXd now_;
  Eigen::VectorXd next_;
};

struct ReducedTransientOptions {
  /// Air temperature at the start. The gyro starts in the steady state at this temperature, switched on unless `cold`.
  Celsius start{20};
  /// Starts at rest with the gyro switched off; the first second switches it on.
  bool cold = false;
  GyroFilm film = GyroFilm::chamber;
  /// Powers in addition to the model's at the start. If empty, no step has additional powers.
  std::optional<ThermalPowers> added_w{};
  /// Keeps the air conductivity at its initial value.
  bool linear = false;
  /// Interval of updates of the air conductivity.
  int seconds_per_update = 10;
};

/// Returns the states of the switched-on gyro at rest in air of `air_c`, with the gap air at the mean of block and
/// shell.
[[nodiscard]] Eigen::VectorXd states_at_rest(const ReducedModel& model, GyroFilm film, double air_c);

/// Returns the model with these powers added to its own.
[[nodiscard]] ReducedModel add_powers(ReducedModel model, const ThermalPowers& added_w);

/// Returns the states of the switched-off gyro at rest: all temperatures equal the air's.
[[nodiscard]] Eigen::VectorXd cold_states_at_rest(const ReducedModel& model, GyroFilm film, double air_c);

/// Returns the temperature of the gap air: the mean of block and shell.
[[nodiscard]] double gap_air_c(const Eigen::Ref<const Eigen::VectorXd>& outputs_c);

class ReducedTransient final {
 public:
  ReducedTransient(const ReducedModel& model, const ReducedTransientOptions& options);

  /// Advances by one second while the chamber's air changes linearly to `air`. Exact for this input and constant
  /// coefficients. `added_w` are powers in addition to the model's during this second. They are permitted only if the
  /// options have added_w.
  void step(Celsius air, std::span<const double> added_w = {});
  /// Switches the model's own powers from the next second on.
  void switch_on(bool on) { on_ = on; }

  /// Returns the outputs in the order of ThermalOutput, °C.
  [[nodiscard]] std::span<const double, kThermalOutputs> outputs_c() const;

 private:
  /// Selects the integration method. For constant coefficients it converts the states to amplitudes of modes.
  std::variant<ModalSecond, StepTable> make_stepper(const ReducedModel& model);

  ReducedTransientOptions options_;
  double air_c_;
  long seconds_ = 0;
  bool on_ = true;
  Eigen::VectorXd states_;
  /// Outputs of the states in the basis of the method.
  Eigen::MatrixXd outputs_;
  std::variant<ModalSecond, StepTable> stepper_;
  Eigen::Vector<double, kThermalOutputs> outputs_c_;
};

}  // namespace gyrotherm::thermal
