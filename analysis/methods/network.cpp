// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "analysis/methods/held_out.hpp"
#include "analysis/svm/cholesky.hpp"
#include "analysis/svm/lanes.hpp"
#include "core/random.hpp"

namespace gyrotherm::methods {
namespace {

/// Computes tanh of each element from one fast pass of exp. The absolute error is about the rounding error of the
/// number 1.
Eigen::MatrixXd fast_tanh(const Eigen::MatrixXd& sums) {
  Eigen::MatrixXd shrunk = sums.cwiseAbs();
  svm::exponentiate(shrunk.data(), shrunk.size(), -2, shrunk.data());
  return ((1 - shrunk.array()) / (1 + shrunk.array())) *
         (sums.array() < 0).select(-1.0, Eigen::ArrayXXd::Ones(sums.rows(), sums.cols()));
}

/// Computes the outputs of the hidden units, units × samples.
Eigen::MatrixXd hidden_outputs(const NetworkModel& network, const data::SampleMatrix& x) {
  return fast_tanh((network.weights * x.transpose()).colwise() + network.offsets);
}

Eigen::VectorXd value_at(const NetworkModel& network, const Eigen::MatrixXd& hidden) {
  return (hidden.transpose() * network.out).array() + network.b;
}

constexpr std::array kHidden = {5, 10, 20};
constexpr std::array kSteps = {5, 10, 15, 20, 30, 40, 60};
constexpr std::size_t kQuickHidden = 2, kQuickSteps = 6;  // number of values tried
constexpr std::size_t kStarts = 10;

std::uint64_t start_seed(const MethodOptions& options, std::size_t start) { return options.seed * kStarts + start; }

/// Predicts the held-out rows after each number of steps in `marks` for one start.
Eigen::MatrixXd predict_at_steps(const Fold& fold, int hidden, std::uint64_t seed, std::span<const int> marks) {
  LevenbergMarquardt training(random_network(fold.train_x.cols(), hidden, seed), fold.train_x, fold.train_y);
  Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(marks.size()));
  int steps = 0;
  bool improving = true;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    while (improving && steps < marks[i]) {
      improving = training.step();
      ++steps;
    }
    predicted.col(static_cast<Eigen::Index>(i)) = evaluate_function(training.network(), fold.test_x);
  }
  return predicted;
}

/// Returns the start with the lower median error of the ten after the given number of steps.
std::size_t median_start(std::span<const Eigen::VectorXd> starts, Eigen::Index steps) {
  std::array<std::size_t, kStarts> order{};
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, {}, [&](std::size_t start) { return starts[start](steps); });
  return order[(kStarts - 1) / 2];
}

}  // namespace

NetworkModel random_network(Eigen::Index inputs, int hidden, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  // A uniform variable in ±√3 has the variance 1.
  const auto draw = [&](double deviation) { return deviation * std::sqrt(3.0) * (2 * uniform(generator) - 1); };
  const double inner = 1 / std::sqrt(static_cast<double>(inputs) + 1), outer = 1 / std::sqrt(hidden);
  NetworkModel network{.weights = data::SampleMatrix(hidden, inputs),
                       .offsets = Eigen::VectorXd(hidden),
                       .out = Eigen::VectorXd(hidden),
                       .b = 0};
  for (double& weight : network.weights.reshaped()) weight = draw(inner);
  for (double& offset : network.offsets) offset = draw(inner);
  for (double& weight : network.out) weight = draw(outer);
  return network;
}

Eigen::VectorXd parameter_vector(const NetworkModel& network) {
  Eigen::VectorXd numbers(network.weights.size() + 2 * network.out.size() + 1);
  numbers << network.weights.reshaped<Eigen::RowMajor>(), network.offsets, network.out, network.b;
  return numbers;
}

void set_parameters(NetworkModel& network, const Eigen::VectorXd& numbers) {
  const Eigen::Index hidden = network.out.size(), inner = network.weights.size();
  network.weights.reshaped<Eigen::RowMajor>() = numbers.head(inner);
  network.offsets = numbers.segment(inner, hidden);
  network.out = numbers.segment(inner + hidden, hidden);
  network.b = numbers(numbers.size() - 1);
}

Linearisation linearise(const NetworkModel& network, const data::SampleMatrix& x) {
  const Eigen::Index hidden = network.out.size(), inputs = x.cols(), samples = x.rows();
  const Eigen::MatrixXd units = hidden_outputs(network, x);
  Linearisation at{.value = value_at(network, units),
                   .derivatives = Eigen::MatrixXd(hidden * (inputs + 2) + 1, samples)};
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

LevenbergMarquardt::LevenbergMarquardt(NetworkModel start, const data::SampleMatrix& x, const Eigen::VectorXd& y)
    : network_(std::move(start)),
      x_(x),
      y_(y),
      squared_error_((value_at(network_, hidden_outputs(network_, x)) - y).squaredNorm()) {}

bool LevenbergMarquardt::step() {
  constexpr double kLargestMu = 1e10, kLeastMu = 1e-12;
  const Linearisation at = linearise(network_, x_);
  const Eigen::VectorXd gradient = at.derivatives * (at.value - y_);
  const Eigen::VectorXd numbers = parameter_vector(network_);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(numbers.size(), numbers.size());
  svm::subtract_square(at.derivatives, normal);
  for (; mu_ <= kLargestMu; mu_ *= 10) {
    Eigen::MatrixXd factor = -normal;
    factor.diagonal().array() += mu_;
    if (!svm::factor_cholesky(factor)) continue;
    Eigen::MatrixXd change = -gradient;
    svm::solve_cholesky(factor, change);
    NetworkModel next = network_;
    set_parameters(next, numbers + change.col(0));
    const double error = (value_at(next, hidden_outputs(next, x_)) - y_).squaredNorm();
    if (!(error < squared_error_)) continue;
    network_ = std::move(next);
    squared_error_ = error;
    mu_ = std::max(mu_ / 10, kLeastMu);
    return true;
  }
  return false;
}

Result<Choice> choose_network(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  const auto sizes = std::span<const int>(kHidden).first(options.quick ? kQuickHidden : kHidden.size());
  const auto marks = std::span<const int>(kSteps).first(options.quick ? kQuickSteps : kSteps.size());
  const Trial train = [&](const Fold& fold, std::size_t trial) -> Result<Eigen::MatrixXd> {
    if (const auto sound = check_set({fold.train_x, fold.train_y, fold.terms}, 2); !sound)
      return failure(sound.error());
    return predict_at_steps(fold, sizes[trial / kStarts], start_seed(options, trial % kStarts), marks);
  };
  const auto errors = held_out_errors(folds, sizes.size() * kStarts, train, options, progress);
  if (!errors) return failure(errors.error());
  Choice choice;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t size = 0; size < sizes.size(); ++size) {
    const auto starts = std::span(*errors).subspan(size * kStarts, kStarts);
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(marks.size()); ++i) {
      const std::size_t median = median_start(starts, i);
      if (!(starts[median](i) < least)) continue;
      least = starts[median](i);
      choice.parameters = {{"hidden units", static_cast<double>(sizes[size])},
                           {"steps", static_cast<double>(marks[i])},
                           {"start", static_cast<double>(median)}};
    }
  }
  if (!choice.parameters.empty()) return choice;
  return failure(FaultKind::numeric, "network", "more than half of the starts have no finite held-out error");
}

Result<Fit> fit_network(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const int hidden = static_cast<int>(parameter_value(parameters, "hidden units"));
  const auto start = static_cast<std::size_t>(parameter_value(parameters, "start"));
  LevenbergMarquardt training(random_network(set.x.cols(), hidden, start_seed(options, start)), set.x, set.y);
  const int requested = static_cast<int>(parameter_value(parameters, "steps"));
  int steps = 0;
  while (steps < requested && training.step()) ++steps;
  const NetworkModel& network = training.network();
  const int weights = count_stored_numbers(network);
  return Fit{.function = network,
             .effective_parameters = static_cast<double>(std::min<Eigen::Index>(weights, set.x.rows())),
             .particulars = fmt::format("stopped after {} steps, the median of {} starts; {} weights, "
                                        "effectively fewer because of early stopping",
                                        steps, kStarts, weights)};
}

}  // namespace gyrotherm::methods
