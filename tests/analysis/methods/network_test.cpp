// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/network.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/methods/held_out.hpp"
#include "tests/analysis/random_samples.hpp"

namespace gyrotherm::methods {
namespace {

TEST(Network, ComputesDerivativesThatMatchDifferences) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const data::SampleMatrix x = 2 * data::normal_matrix(7, 3, seed);
    NetworkModel network = random_network(3, 4, seed);
    network.b = 0.3;
    const Linearisation at = linearise(network, x);
    EXPECT_LT((at.value - evaluate_function(network, x)).cwiseAbs().maxCoeff(), 1e-14) << "seed " << seed;
    const Eigen::VectorXd numbers = parameter_vector(network);
    ASSERT_EQ(numbers.size(), count_stored_numbers(network));
    for (Eigen::Index k = 0; k < numbers.size(); ++k) {
      constexpr double kStep = 1e-5;
      NetworkModel ahead = network, behind = network;
      set_parameters(ahead, numbers + kStep * Eigen::VectorXd::Unit(numbers.size(), k));
      set_parameters(behind, numbers - kStep * Eigen::VectorXd::Unit(numbers.size(), k));
      const Eigen::VectorXd slope = (evaluate_function(ahead, x) - evaluate_function(behind, x)) / (2 * kStep);
      EXPECT_LT((slope - at.derivatives.row(k).transpose()).cwiseAbs().maxCoeff(), 1e-8) << "seed " << seed << " " << k;
    }
  }
}

TEST(Network, RoundTripsParameters) {
  const NetworkModel network = random_network(3, 2, 5);
  NetworkModel other = random_network(3, 2, 6);
  set_parameters(other, parameter_vector(network));
  EXPECT_EQ(other.weights, network.weights);
  EXPECT_EQ(other.offsets, network.offsets);
  EXPECT_EQ(other.out, network.out);
}

TEST(LevenbergMarquardt, LowersErrorWithEachStep) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const data::Samples samples = data::bent_samples(80, 3, 0.1, seed);
    LevenbergMarquardt training(random_network(3, 5, seed), samples.x, samples.y);
    double before = training.squared_error();
    for (int step = 0; step < 30 && training.step(); ++step) {
      EXPECT_LT(training.squared_error(), before) << "seed " << seed;
      before = training.squared_error();
      EXPECT_NEAR((evaluate_function(training.network(), samples.x) - samples.y).squaredNorm(), before, 1e-12);
    }
  }
}

TEST(LevenbergMarquardt, RecoversKnownNetwork) {
  data::Samples samples{data::normal_matrix(150, 2, 1), {}, data::letters(2)};
  samples.y = (samples.x * Eigen::Vector2d{1.5, -1}).array().tanh() * 2 + 0.5;
  LevenbergMarquardt training(random_network(2, 2, 3), samples.x, samples.y);
  for (int step = 0; step < 200 && training.step(); ++step) {
  }
  EXPECT_LT(training.squared_error(), 1e-12);
}

TEST(LevenbergMarquardt, StopsAtStationaryPoint) {
  const data::Samples samples = data::bent_samples(40, 2, 0.3, 2);
  LevenbergMarquardt training(random_network(2, 2, 1), samples.x, samples.y);
  int steps = 0;
  while (steps < 5000 && training.step()) ++steps;
  EXPECT_LT(steps, 5000);
  const Linearisation at = linearise(training.network(), samples.x);
  EXPECT_LT((at.derivatives * (at.value - samples.y)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(BackPropagationNetwork, KeepsStartWithMedianHeldOutError) {
  const data::Samples samples = data::bent_samples(90, 2, 0.3, 8);
  const auto folds = folds_of(samples, 3);
  const auto choice = choose_network(folds, {.seed = 4}, {});
  ASSERT_TRUE(choice);
  const double chosen = parameter_value(choice->parameters, "start");
  std::vector<double> errors(10);
  for (int start = 0; start < 10; ++start) {
    HyperParameters parameters = choice->parameters;
    parameters[2].value = start;
    for (const Fold& fold : folds) {
      const auto fit = fit_network({fold.train_x, fold.train_y, fold.terms}, parameters, {.seed = 4});
      ASSERT_TRUE(fit);
      errors[start] += (evaluate_function(fit->function, fold.test_x) - fold.test_y).squaredNorm();
    }
  }
  const double chosen_error = errors[static_cast<std::size_t>(chosen)];
  EXPECT_EQ(std::ranges::count_if(errors, [&](double error) { return error < chosen_error; }), 4);
}

TEST(BackPropagationNetwork, FitsNonlinearFunction) {
  const data::Samples samples = data::bent_samples(400, 2, 0.05, 9);
  const auto choice = choose_network(folds_of(samples, 4), {}, {});
  ASSERT_TRUE(choice);
  const auto fit = fit_network(samples.set(), choice->parameters, {});
  ASSERT_TRUE(fit);
  const data::Samples unseen = data::bent_samples(400, 2, 0, 10);
  EXPECT_LT((evaluate_function(fit->function, unseen.x) - unseen.y).norm(), 0.15 * unseen.y.norm());
}

}  // namespace
}  // namespace gyrotherm::methods
