/// A reduced model at constant coefficients: its modes, and what one second does to it.
#pragma once

#include <Eigen/Core>

#include "thermal/reduced/reduced_model.hpp"

namespace gyrotherm {

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
  Eigen::ArrayXd decay;
  Eigen::ArrayXd before;
  Eigen::ArrayXd after;
};

[[nodiscard]] ModalWeights modal_weights(const Eigen::VectorXd& rates_per_s, double step_s);

/// One second with the model's powers on, in the basis of the states: x⁺ = carry x + before T + after T⁺ + powers,
/// T in °C of the air outside.
struct OneSecond {
  Eigen::MatrixXd carry;  ///< symmetric
  Eigen::VectorXd before;
  Eigen::VectorXd after;
  Eigen::VectorXd powers;
};

[[nodiscard]] OneSecond one_second(const ReducedModel& model, const ThermalCoefficients& c);

}  // namespace gyrotherm
