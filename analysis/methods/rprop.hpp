// SPDX-License-Identifier: Apache-2.0
/// The steps of an ascent that asks the signs of the derivatives and not their sizes.
#pragma once

#include <Eigen/Core>

namespace gyrotherm::methods {

/// Rprop (Blum and Riedmiller, Optimization of Gaussian process hyperparameters using Rprop, ESANN 2013): each
/// coordinate has a step of its own, which grows while its derivative keeps its sign and shrinks where that turns.
class RpropSteps {
 public:
  /// Steps of 0.2 in each of so many coordinates; they stay within 1e-6 … 1.
  explicit RpropSteps(Eigen::Index coordinates);

  /// The step uphill from where this is the gradient. A coordinate whose derivative has turned since the step before
  /// stands still for one step.
  [[nodiscard]] Eigen::VectorXd next(Eigen::VectorXd gradient);

 private:
  Eigen::VectorXd sizes_, before_;
};

}  // namespace gyrotherm::methods
