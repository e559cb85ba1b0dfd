#include "analysis/methods/levenberg_marquardt.hpp"

#include <cmath>
#include <utility>

#include "analysis/svm/cholesky.hpp"
#include "analysis/svm/vector_exp.hpp"
#include "core/random.hpp"

namespace gyrotherm {
namespace {

/// tanh of each, from one fast pass of exp; right to rounding of 1.
Eigen::MatrixXd tanh_of(const Eigen::MatrixXd& sums) {
  Eigen::MatrixXd shrunk = sums.cwiseAbs();
  exponentiate(shrunk.data(), shrunk.size(), -2, shrunk.data());
  return ((1 - shrunk.array()) / (1 + shrunk.array())) *
         (sums.array() < 0).select(-1.0, Eigen::ArrayXXd::Ones(sums.rows(), sums.cols()));
}

/// Hidden units' outputs, units × samples.
Eigen::MatrixXd hidden_of(const NetworkModel& network, const SampleMatrix& x) {
  return tanh_of((network.weights * x.transpose()).colwise() + network.offsets);
}

Eigen::VectorXd value_at(const NetworkModel& network, const Eigen::MatrixXd& hidden) {
  return (hidden.transpose() * network.out).array() + network.b;
}

}  // namespace

NetworkModel random_network(Eigen::Index inputs, int hidden, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  // Uniform in ±√3 has the variance 1.
  const auto draw = [&](double deviation) { return deviation * std::sqrt(3.0) * (2 * uniform(generator) - 1); };
  const double inner = 1 / std::sqrt(static_cast<double>(inputs) + 1), outer = 1 / std::sqrt(hidden);
  NetworkModel network{.weights = SampleMatrix(hidden, inputs),
                       .offsets = Eigen::VectorXd(hidden),
                       .out = Eigen::VectorXd(hidden),
                       .b = 0};
  for (double& weight : network.weights.reshaped()) weight = draw(inner);
  for (double& offset : network.offsets) offset = draw(inner);
  for (double& weight : network.out) weight = draw(outer);
  return network;
}

Eigen::VectorXd numbers_of(const NetworkModel& network) {
  Eigen::VectorXd numbers(network.weights.size() + 2 * network.out.size() + 1);
  numbers << network.weights.reshaped<Eigen::RowMajor>(), network.offsets, network.out, network.b;
  return numbers;
}

void set_numbers(NetworkModel& network, const Eigen::VectorXd& numbers) {
  const Eigen::Index hidden = network.out.size(), inner = network.weights.size();
  network.weights.reshaped<Eigen::RowMajor>() = numbers.head(inner);
  network.offsets = numbers.segment(inner, hidden);
  network.out = numbers.segment(inner + hidden, hidden);
  network.b = numbers(numbers.size() - 1);
}

Linearised linearise(const NetworkModel& network, const SampleMatrix& x) {
  const Eigen::Index hidden = network.out.size(), inputs = x.cols(), samples = x.rows();
  const Eigen::MatrixXd units = hidden_of(network, x);
  Linearised at{.value = value_at(network, units), .derivatives = Eigen::MatrixXd(hidden * (inputs + 2) + 1, samples)};
  const Eigen::MatrixXd slopes = (1 - units.array().square()).colwise() * network.out.array();
  for (Eigen::Index i = 0; i < samples; ++i) {
    auto column = at.derivatives.col(i);
    for (Eigen::Index k = 0; k < hidden; ++k) column.segment(k * inputs, inputs) = slopes(k, i) * x.row(i).transpose();
    column.segment(hidden * inputs, hidden) = slopes.col(i);
    column.segment(hidden * (inputs + 1), hidden) = units.col(i);
    column(hidden * (inputs + 2)) = 1;
  }
  return at;
}

LevenbergMarquardt::LevenbergMarquardt(NetworkModel start, const SampleMatrix& x, const Eigen::VectorXd& y)
    : network_(std::move(start)),
      x_(x),
      y_(y),
      squared_error_((value_at(network_, hidden_of(network_, x)) - y).squaredNorm()) {}

bool LevenbergMarquardt::step() {
  constexpr double kLargestMu = 1e10, kLeastMu = 1e-12;
  const Linearised at = linearise(network_, x_);
  const Eigen::VectorXd gradient = at.derivatives * (at.value - y_);
  const Eigen::VectorXd numbers = numbers_of(network_);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(numbers.size(), numbers.size());
  subtract_square(at.derivatives, normal);
  for (; mu_ <= kLargestMu; mu_ *= 10) {
    Eigen::MatrixXd factor = -normal;
    factor.diagonal().array() += mu_;
    if (!factor_cholesky(factor)) continue;
    Eigen::MatrixXd change = -gradient;
    solve_cholesky(factor, change);
    NetworkModel next = network_;
    set_numbers(next, numbers + change.col(0));
    const double error = (value_at(next, hidden_of(next, x_)) - y_).squaredNorm();
    if (!(error < squared_error_)) continue;
    network_ = std::move(next);
    squared_error_ = error;
    mu_ = std::max(mu_ / 10, kLeastMu);
    return true;
  }
  return false;
}

}  // namespace gyrotherm
