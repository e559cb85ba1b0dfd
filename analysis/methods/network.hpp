// SPDX-License-Identifier: Apache-2.0
/// Back-propagation network of one hidden layer: ŷ = v_0 + Σ_{k=1}^{h} v_k tanh(w_k0 + w_kᵀz), trained by
/// Levenberg–Marquardt (Yang, Qin and You, Proc. SPIE 7544 (2010), ref. 7 of the paper).
///
/// A network depends on where its training starts, so ten seeded starts are tried. For each number of hidden units and
/// of steps their ten held-out errors are sorted; the median decides, not the luckiest. Stopping early is choosing the
/// number of steps with the least such median. The stored network is the start that is the (lower) median itself, so
/// that its held-out figures are those of a usual start. Quick: at most 10 hidden units and 40 steps.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "analysis/methods/method.hpp"

namespace gyrotherm::methods {

/// A network to start from: hidden weights are uniform with a variance of one by the number of inputs and the offset,
/// so that sums begin inside the tanh's bend; output weights likewise by the number of hidden units.
[[nodiscard]] NetworkModel random_network(Eigen::Index inputs, int hidden, std::uint64_t seed);

/// The network's numbers in one row: weights of one hidden unit after the other, offsets, out, b.
[[nodiscard]] Eigen::VectorXd numbers_of(const NetworkModel& network);
/// Puts such numbers back into a network of that shape.
void set_numbers(NetworkModel& network, const Eigen::VectorXd& numbers);

/// Values of the network at each sample, and their derivatives by its numbers: numbers × samples.
struct Linearised {
  Eigen::VectorXd value;
  Eigen::MatrixXd derivatives;
};
[[nodiscard]] Linearised linearise(const NetworkModel& network, const data::SampleMatrix& x);

/// Trains a network of one hidden tanh layer by Levenberg–Marquardt (Hagan and Menhaj, IEEE Trans. Neural Networks 5
/// (1994) 989), one step at a time: (JᵀJ + µI)δ = −Jᵀe, e = ŷ − y; µ is divided by 10 after a step that lowers Σe²,
/// multiplied by 10 after one that does not.
class LevenbergMarquardt {
 public:
  /// Begins at `start`. The samples x and targets y outlive it.
  LevenbergMarquardt(NetworkModel start, const data::SampleMatrix& x, const Eigen::VectorXd& y);
  /// Takes one step that lowers the error; false if there is none.
  [[nodiscard]] bool step();
  [[nodiscard]] const NetworkModel& network() const { return network_; }
  [[nodiscard]] double squared_error() const { return squared_error_; }  ///< Σe²

 private:
  NetworkModel network_;
  const data::SampleMatrix& x_;
  const Eigen::VectorXd& y_;
  double mu_ = 1e-3;
  double squared_error_{};
};

/// Chooses "hidden units" of 5, 10 or 20, "steps" of Levenberg–Marquardt, and "start", which of the ten, 0 … 9, by
/// held-out error.
[[nodiscard]] ChooseFunction choose_network;

/// The effective parameters are all weights, at most the samples; fewer steps make them less. Fails with usage if there
/// is one sample only.
[[nodiscard]] FitFunction fit_network;

}  // namespace gyrotherm::methods
