#include "thermal/reduced/thermal_modes.hpp"

#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>

namespace gyrotherm {

ThermalModes modes_of(const ReducedModel& model, const ThermalCoefficients& c) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(conduction_at(model, c));
  assert(eigen.info() == Eigen::Success && eigen.eigenvalues()[0] > 0);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

ModalWeights modal_weights(const Eigen::VectorXd& rates_per_s, double step_s) {
  constexpr double kSeries = 1e-3;  // below, the closed form loses more digits than the series leaves out
  ModalWeights w{Eigen::ArrayXd(rates_per_s.size()), Eigen::ArrayXd(rates_per_s.size()),
                 Eigen::ArrayXd(rates_per_s.size())};
  for (Eigen::Index i = 0; i < rates_per_s.size(); ++i) {
    const double z = rates_per_s[i] * step_s;
    const double lost = -std::expm1(-z);
    w.decay[i] = std::exp(-z);
    w.after[i] =
        z < kSeries ? step_s * (1.0 / 2 - z * (1.0 / 6 - z * (1.0 / 24 - z / 120))) : step_s * (1 - lost / z) / z;
    w.before[i] = step_s * lost / z - w.after[i];
  }
  return w;
}

OneSecond one_second(const ReducedModel& model, const ThermalCoefficients& c) {
  const auto modes = modes_of(model, c);
  const auto weights = modal_weights(modes.rates_per_s, 1);
  const Eigen::MatrixXd inputs = modes.shapes.transpose() * inputs_at(model, c);
  const auto at = [&](const Eigen::ArrayXd& amplitudes) -> Eigen::VectorXd {
    return modes.shapes * amplitudes.matrix();
  };
  const Eigen::ArrayXd powers = inputs * switched_on(model, 0);
  return {.carry = modes.shapes * weights.decay.matrix().asDiagonal() * modes.shapes.transpose(),
          .before = at(weights.before * inputs.col(0).array()),
          .after = at(weights.after * inputs.col(0).array()),
          .powers = at((weights.before + weights.after) * powers)};
}

}  // namespace gyrotherm
