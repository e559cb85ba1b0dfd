/// Trains a network of one hidden tanh layer by Levenberg–Marquardt (Hagan and Menhaj, IEEE Trans. Neural Networks 5
/// (1994) 989), one step at a time.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "analysis/methods/function.hpp"

namespace gyrotherm {

/// Hidden weights uniform with a variance of one by the number of inputs and the offset, so that sums begin inside the
/// tanh's bend; output weights likewise by the number of hidden units.
[[nodiscard]] NetworkModel random_network(Eigen::Index inputs, int hidden, std::uint64_t seed);

/// The network's numbers in one row: weights of one hidden unit after the other, offsets, out, b.
[[nodiscard]] Eigen::VectorXd numbers_of(const NetworkModel& network);
/// The same way back, into a network of that shape.
void set_numbers(NetworkModel& network, const Eigen::VectorXd& numbers);

/// Values of the network at each sample, and their derivatives by its numbers: numbers × samples.
struct Linearised {
  Eigen::VectorXd value;
  Eigen::MatrixXd derivatives;
};
[[nodiscard]] Linearised linearise(const NetworkModel& network, const SampleMatrix& x);

/// (JᵀJ + µI)δ = −Jᵀe, e = ŷ − y; µ is divided by 10 after a step that lowers Σe², multiplied by 10 after one that does
/// not.
class LevenbergMarquardt {
 public:
  /// Both outlive it.
  LevenbergMarquardt(NetworkModel start, const SampleMatrix& x, const Eigen::VectorXd& y);
  /// One step that lowers the error; false if there is none.
  [[nodiscard]] bool step();
  [[nodiscard]] const NetworkModel& network() const { return network_; }
  [[nodiscard]] double squared_error() const { return squared_error_; }  ///< Σe²

 private:
  NetworkModel network_;
  const SampleMatrix& x_;
  const Eigen::VectorXd& y_;
  double mu_ = 1e-3;
  double squared_error_{};
};

}  // namespace gyrotherm
