// SPDX-License-Identifier: Apache-2.0
/// Back-propagation network with one hidden layer: ŷ = v_0 + Σ_{k=1}^{h} v_k tanh(w_k0 + w_kᵀz), trained by
/// Levenberg–Marquardt (Yang, Qin and You, Proc. SPIE 7544 (2010), ref. 7 of the paper).
///
/// A trained network depends on its random start, so ten seeded starts are tried. For each number of hidden units and
/// of steps, the ten starts have ten held-out errors. Their median is compared, not the lowest. Early stopping chooses
/// the number of steps with the lowest median. The stored network uses the start with the median error (the lower of
/// the two middle ones), so its held-out errors are those of a typical start. Quick: at most 10 hidden units and 40
/// steps.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// Returns a random start. Hidden weights are uniform with the variance 1/(inputs + 1), which keeps the initial sums
/// within the bend of tanh. Output weights are uniform with the variance 1/hidden.
[[nodiscard]] NetworkModel random_network(Eigen::Index inputs, int hidden, std::uint64_t seed);

/// Returns all parameters in one vector: the weights of each hidden unit in turn, then offsets, out and b.
[[nodiscard]] Eigen::VectorXd parameter_vector(const NetworkModel& network);
/// Sets all parameters of `network` from the parameter_vector() of a network of the same shape.
void set_parameters(NetworkModel& network, const Eigen::VectorXd& numbers);

/// Values of the network at each sample, and their derivatives with respect to its parameters: parameters × samples.
struct Linearisation {
  Eigen::VectorXd value;
  Eigen::MatrixXd derivatives;
};
[[nodiscard]] Linearisation linearise(const NetworkModel& network, const data::SampleMatrix& x);

/// Levenberg–Marquardt training of a network with one hidden tanh layer, one step at a time (Hagan and Menhaj, IEEE
/// Trans. Neural Networks 5 (1994) 989): (JᵀJ + µI)δ = −Jᵀe, e = ŷ − y. µ is divided by 10 after a step that lowers Σe²
/// and multiplied by 10 after any other step.
class LevenbergMarquardt {
 public:
  /// Begins at `start`. The samples x and targets y must outlive the object.
  LevenbergMarquardt(NetworkModel start, const data::SampleMatrix& x, const Eigen::VectorXd& y);
  /// Takes one step that lowers the error. Returns false if no such step is found.
  [[nodiscard]] bool step();
  [[nodiscard]] const NetworkModel& network() const { return network_; }
  /// Returns Σe².
  [[nodiscard]] double squared_error() const { return squared_error_; }

 private:
  NetworkModel network_;
  const data::SampleMatrix& x_;
  const Eigen::VectorXd& y_;
  double mu_ = 1e-3;
  double squared_error_{};
};

/// Chooses "hidden units" (5, 10 or 20), "steps" of Levenberg–Marquardt, and "start", the index 0…9 of the start, by
/// held-out error.
[[nodiscard]] ChooseFunction choose_network;

/// Fits the network. The number of effective parameters is the number of all parameters, at most the number of samples.
/// The actual number is lower because of early stopping. Fails with usage if there is only one sample.
[[nodiscard]] FitFunction fit_network;

}  // namespace gyrotherm::methods
