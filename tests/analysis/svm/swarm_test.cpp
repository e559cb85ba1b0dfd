// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/swarm.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <set>
#include <thread>

namespace gyrotherm::svm {
namespace {

const SwarmBox kBox{.lower = {-5, -5, -5}, .upper = {5, 5, 5}};

Result<double> sphere(std::size_t, const std::vector<double>& x, double) {
  double sum = 0;
  for (const double value : x) sum += (value - 1) * (value - 1);
  return sum;
}

Result<double> rosenbrock(std::size_t, const std::vector<double>& x, double) {
  return 100 * std::pow(x[1] - x[0] * x[0], 2) + std::pow(1 - x[0], 2);
}

SwarmOptions patient(int iterations) {
  SwarmOptions options;
  options.iterations = iterations;
  options.stall_iterations = iterations + 1;
  return options;
}

TEST(Swarm, FindsMinimumOfSphere) {
  const auto summary = minimise(sphere, kBox, patient(200));
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->end, SwarmEnd::iterations_done);
  EXPECT_LT(summary->best_fitness, 1e-4);
  for (const double value : summary->best) EXPECT_NEAR(value, 1, 1e-2);
}

TEST(Swarm, FindsMinimumOfRosenbrock) {
  const auto summary = minimise(rosenbrock, {.lower = {-2, -1}, .upper = {2, 3}}, patient(300));
  ASSERT_TRUE(summary);
  EXPECT_NEAR(summary->best[0], 1, 0.05);
  EXPECT_NEAR(summary->best[1], 1, 0.1);
}

TEST(Swarm, ReducesInertiaFromNineTenthsToFourTenths) {
  const SwarmOptions options;
  EXPECT_DOUBLE_EQ(inertia_weight(options, 0), 0.9);
  EXPECT_DOUBLE_EQ(inertia_weight(options, options.iterations / 2), 0.65);
  EXPECT_DOUBLE_EQ(inertia_weight(options, options.iterations), 0.4);
}

TEST(Swarm, LimitsVelocityBeforeMove) {
  const Coordinate up = move_within_box({.position = 1, .velocity = 9}, 0.5, -5, 5);
  EXPECT_EQ(up.position, 1.5);
  EXPECT_EQ(up.velocity, 0.5);
  const Coordinate down = move_within_box({.position = 1, .velocity = -9}, 0.5, -5, 5);
  EXPECT_EQ(down.position, 0.5);
  EXPECT_EQ(down.velocity, -0.5);
}

TEST(Swarm, StopsAtEdgeOfBox) {
  const Coordinate out = move_within_box({.position = 4.8, .velocity = 0.4}, 0.5, -5, 5);
  EXPECT_EQ(out.position, 5);
  EXPECT_EQ(out.velocity, 0);
  const Coordinate onto = move_within_box({.position = 4.5, .velocity = 0.5}, 0.5, -5, 5);
  EXPECT_EQ(onto.position, 5);
  EXPECT_EQ(onto.velocity, 0.5);
}

TEST(Swarm, StaysInsideBox) {
  std::atomic<int> outside = 0;
  const Fitness fitness = [&](std::size_t, const std::vector<double>& x, double limit) {
    for (std::size_t k = 0; k < x.size(); ++k) outside += x[k] < kBox.lower[k] || x[k] > kBox.upper[k];
    return sphere(0, x, limit);
  };
  ASSERT_TRUE(minimise(fitness, kBox, patient(50)));
  EXPECT_EQ(outside, 0);
}

void expect_equal(const SwarmSummary& a, const SwarmSummary& b) {
  EXPECT_EQ(a.best, b.best);
  EXPECT_EQ(a.history, b.history);
  EXPECT_EQ(a.evaluations, b.evaluations);
  EXPECT_EQ(a.end, b.end);
}

TEST(Swarm, DoesNotDependOnThreadCount) {
  SwarmOptions options = patient(40);
  options.threads = 1;
  const auto one = minimise(sphere, kBox, options);
  for (const int threads : {2, 3, 0}) {
    options.threads = threads;
    const auto many = minimise(sphere, kBox, options);
    ASSERT_TRUE(one && many);
    expect_equal(*one, *many);
  }
}

TEST(Swarm, TakesDifferentPathWithDifferentSeed) {
  SwarmOptions options = patient(3);
  const auto first = minimise(sphere, kBox, options);
  options.seed = 2;
  const auto second = minimise(sphere, kBox, options);
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->history, second->history);
}

TEST(Swarm, IsUnchangedByFitnessThatStopsAtLimit) {
  std::atomic<int> stopped = 0;
  const Fitness stopping = [&](std::size_t, const std::vector<double>& x, double limit) -> Result<double> {
    double sum = 0;
    for (const double value : x) {
      sum += (value - 1) * (value - 1);
      if (sum <= limit) continue;
      ++stopped;
      break;
    }
    return sum;
  };
  const auto whole = minimise(sphere, kBox, patient(60));
  const auto partial = minimise(stopping, kBox, patient(60));
  ASSERT_TRUE(whole && partial);
  EXPECT_GT(stopped, 100);
  expect_equal(*whole, *partial);
}

TEST(Swarm, StopsWithoutGain) {
  SwarmOptions options;
  options.iterations = 100;
  options.stall_iterations = 4;
  const auto summary = minimise([](std::size_t, const auto&, double) -> Result<double> { return 1.0; }, kBox, options);
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->end, SwarmEnd::stalled);
  EXPECT_EQ(summary->evaluations, options.particles * 5);
}

TEST(Swarm, RecordsBestAfterEachIteration) {
  const auto summary = minimise(sphere, kBox, patient(25));
  ASSERT_TRUE(summary);
  ASSERT_EQ(summary->history.size(), 26u);
  for (std::size_t t = 1; t < summary->history.size(); ++t) EXPECT_LE(summary->history[t], summary->history[t - 1]);
  EXPECT_EQ(summary->history.back(), summary->best_fitness);
}

TEST(Swarm, ReportsCoordinatesOnEdge) {
  const Fitness downhill = [](std::size_t, const std::vector<double>& x, double) -> Result<double> {
    return x[0] + (x[1] - 1) * (x[1] - 1);
  };
  const auto summary = minimise(downhill, {.lower = {-5, -5}, .upper = {5, 5}}, patient(60));
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->coordinates_on_edge, std::vector<int>{0});
}

TEST(Swarm, IgnoresInfiniteFitness) {
  const Fitness half = [](std::size_t, const std::vector<double>& x, double limit) -> Result<double> {
    if (x[0] < 0) return std::numeric_limits<double>::infinity();
    if (x[1] < 0) return std::numeric_limits<double>::quiet_NaN();
    return sphere(0, x, limit);
  };
  const auto summary = minimise(half, kBox, patient(60));
  ASSERT_TRUE(summary);
  EXPECT_GE(summary->best[0], 0);
  EXPECT_GE(summary->best[1], 0);
  EXPECT_LT(summary->best_fitness, 0.1);
}

TEST(Swarm, CallsProgressOnlyFromCallingThread) {
  SwarmOptions options = patient(5);
  options.threads = 2;
  std::set<std::thread::id> callers;
  double last = 0;
  const auto summary = minimise(sphere, kBox, options, [&](std::string_view, double fraction) {
    callers.insert(std::this_thread::get_id());
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    last = fraction;
    return true;
  });
  ASSERT_TRUE(summary);
  EXPECT_EQ(callers, std::set{std::this_thread::get_id()});
  EXPECT_EQ(last, 1);
}

TEST(Swarm, StopsWithinFewEvaluationsWhenInterrupted) {
  for (const int threads : {1, 2}) {
    SwarmOptions options = patient(1000);
    options.threads = threads;
    std::atomic<int> evaluations = 0;
    const Fitness counting = [&](std::size_t, const std::vector<double>& x, double limit) {
      ++evaluations;
      return sphere(0, x, limit);
    };
    int calls = 0;
    const auto summary = minimise(counting, kBox, options, [&](std::string_view, double) { return ++calls < 3; });
    ASSERT_FALSE(summary);
    EXPECT_EQ(summary.error().kind, FaultKind::interrupted);
    EXPECT_LE(evaluations, 3 * options.particles);
  }
}

TEST(Swarm, FailsWithFaultOfFirstParticle) {
  const Fitness failing = [&](std::size_t, const std::vector<double>& x, double) -> Result<double> {
    return failure(FaultKind::numeric, "here", std::to_string(x[0]));
  };
  SwarmOptions options;
  options.threads = 1;
  const auto one = minimise(failing, kBox, options);
  options.threads = 2;
  const auto two = minimise(failing, kBox, options);
  ASSERT_FALSE(one);
  ASSERT_FALSE(two);
  EXPECT_EQ(one.error().kind, FaultKind::numeric);
  EXPECT_EQ(one.error().what, two.error().what);
}

TEST(Swarm, NamesInvalidOption) {
  SwarmOptions options;
  options.particles = 0;
  EXPECT_EQ(minimise(sphere, kBox, options).error().what, "particles = 0, must be at least 1");
  options = {};
  options.v_max = 0;
  EXPECT_EQ(minimise(sphere, kBox, options).error().what, "v_max = 0, must be positive");
  for (const double v_max : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    options.v_max = v_max;
    const auto summary = minimise(sphere, kBox, options);
    ASSERT_FALSE(summary) << v_max;
    EXPECT_EQ(summary.error().kind, FaultKind::usage);
  }
  const auto upside_down = minimise(sphere, {.lower = {1}, .upper = {0}}, {});
  ASSERT_FALSE(upside_down);
  EXPECT_EQ(upside_down.error().kind, FaultKind::usage);
  EXPECT_EQ(upside_down.error().what, "coordinate 0 has the limits 1 and 0, must be finite and in order");
}

}  // namespace
}  // namespace gyrotherm::svm
