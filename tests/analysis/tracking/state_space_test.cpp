// SPDX-License-Identifier: Apache-2.0
#include "analysis/tracking/state_space.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "analysis/tracking/bias_tracker.hpp"
#include "tests/analysis/tracking/known_bias.hpp"

namespace gyrotherm::tracking {
namespace {

/// Returns the Allan variance at τ of a Markov process with variance 1 and correlation time 1 (IEEE Std 952-1997, annex
/// C).
double allan_variance_of_markov(double tau) {
  return 2 / tau * (1 - (3 - 4 * std::exp(-tau) + std::exp(-2 * tau)) / (2 * tau));
}

TEST(StateSpace, HasWhiteNoiseOfAngleRandomWalk) {
  BiasNoise noise = virtual_noise();
  noise.instability_deg_per_h = 0;
  EXPECT_NEAR(std::sqrt(state_space(noise, 100).white), 1.8e-3, 1e-12) << "60 N/√Δ arcsec/s";
  EXPECT_NEAR(std::sqrt(state_space(noise, 1).white), 0.018, 1e-12);
}

TEST(StateSpace, MatchesAllanDeviationOfFlickerNearCentre) {
  const BiasNoise noise = virtual_noise();
  const auto times_h = correlation_times_h(noise, kInterval_s);
  const double flicker = 2 * std::numbers::ln2 / std::numbers::pi * std::pow(noise.instability_deg_per_h, 2);
  EXPECT_NEAR(flicker, std::pow(noise.angle_random_walk_deg_per_sqrt_h, 2) / times_h[1], 1e-3 * flicker);
  const StateSpace space = state_space(noise, kInterval_s);
  for (const double tau_h : {times_h[1] / 2, times_h[1], 2 * times_h[1]}) {
    double sum = 0;
    for (int m = 0; m < kMarkovProcesses; ++m) sum += space.start(m + 1) * allan_variance_of_markov(tau_h / times_h[m]);
    EXPECT_NEAR(std::sqrt(sum / flicker), 1, 0.1) << tau_h;
  }
}

/// The expected variance is the integral of the two-sided flicker spectrum B²/(2πf) for means over Δ, starting at the
/// frequency above which the first process has no power.
TEST(StateSpace, AddsFasterFlickerToWhiteNoise) {
  BiasNoise noise = virtual_noise();
  for (const double instability : {1e-4, 4e-4, 8e-4, 5e-3}) {
    noise.instability_deg_per_h = 0;
    const double without = state_space(noise, kInterval_s).white;
    noise.instability_deg_per_h = instability;
    const double edge_s = 3600 * correlation_times_h(noise, kInterval_s)[0] / std::sqrt(10);
    double sum = 0;
    // Step of ln f.
    constexpr double kStep = 1e-4;
    for (double f = 1 / (2 * std::numbers::pi * edge_s); f < 100; f *= std::exp(kStep)) {
      const double x = std::numbers::pi * f * kInterval_s;
      sum += 2 * instability * instability / (2 * std::numbers::pi) * std::pow(std::sin(x) / x, 2) * kStep;
    }
    EXPECT_NEAR((state_space(noise, kInterval_s).white - without) / sum, 1, 0.06) << instability;
  }
}

/// Model of a bias with any number of independent states, and the white noise of its measured means.
struct Mismatch {
  Eigen::VectorXd memory, fresh, start;  ///< true states
  double white{};                        ///< measured means
};

Mismatch make_flicker(double instability, const BiasNoise& noise, int processes) {
  Mismatch truth{Eigen::VectorXd::Ones(processes + 1), Eigen::VectorXd::Zero(processes + 1),
                 Eigen::VectorXd::Zero(processes + 1), 1.8e-3 * 1.8e-3};
  const StateSpace walk = state_space(noise, kInterval_s);
  truth.fresh(0) = walk.fresh(0);
  truth.start(0) = walk.start(0);
  // Two processes per decade from 1 s to 1e6 s, as in the virtual gyro.
  for (int m = 1; m <= processes; ++m) {
    const double time = std::pow(10, (m - 1) / 2.0) / kInterval_s;
    truth.memory(m) = std::exp(-1 / time);
    // Factor by which averaging over an interval reduces the variance of the process.
    const double averaged = 2 * time * (1 - time * (1 - truth.memory(m)));
    truth.start(m) = averaged * instability * instability * std::numbers::ln10 / 2 / std::numbers::pi;
    truth.fresh(m) = truth.start(m) * (1 - truth.memory(m) * truth.memory(m));
  }
  return truth;
}

/// Returns the weight of each state in the mean over the next 36 intervals, and the variance of the unpredictable part
/// of that mean.
std::pair<Eigen::VectorXd, double> next_hour_weights(const Eigen::VectorXd& memory, const Eigen::VectorXd& fresh) {
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(memory.size());
  double unknown = 0;
  for (int n = 1; n <= 36; ++n) {
    weight = (1 + weight.array() * memory.array()).eval();
    unknown += weight.cwiseAbs2().dot(fresh);
  }
  return {weight.cwiseProduct(memory) / 36, unknown / (36 * 36)};
}

/// Computes the RMS error of forecasts of the true mean over the next hour, for 1440 intervals after the second hour.
/// The filter assumes the model `belief`. The joint covariance of truth and filter is propagated step by step.
double forecast_error(const Mismatch& truth, const Mismatch& belief) {
  const Eigen::VectorXd &memory = belief.memory, &fresh = belief.fresh;
  const Eigen::Index n = truth.memory.size(), m = memory.size();
  Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(n + m, n + m), believed = belief.start.asDiagonal();
  joint.topLeftCorner(n, n) = truth.start.asDiagonal();
  const auto [truth_weights, unknown] = next_hour_weights(truth.memory, truth.fresh);
  Eigen::VectorXd error(n + m), both(n + m);
  error << truth_weights, -next_hour_weights(memory, fresh).first;
  both << truth.memory, memory;
  double sum = 0;
  for (int k = 0; k < 1440; ++k) {
    const Eigen::VectorXd gain = believed.rowwise().sum() / (believed.sum() + belief.white);
    believed -= (gain * believed.colwise().sum()).eval();
    Eigen::MatrixXd update = Eigen::MatrixXd::Identity(n + m, n + m);
    update.block(n, 0, m, n).colwise() += gain;
    update.block(n, n, m, m).colwise() -= gain;
    joint = (update * joint * update.transpose()).eval();
    joint.block(n, n, m, m) += truth.white * gain * gain.transpose();
    if (k >= 72) sum += error.dot(joint * error) + unknown;
    joint = joint.cwiseProduct(both * both.transpose()).eval();
    joint.diagonal().head(n) += truth.fresh;
    believed = believed.cwiseProduct(memory * memory.transpose()).eval();
    believed.diagonal() += fresh;
  }
  return std::sqrt(sum / (1440 - 72));
}

TEST(StateSpace, ForecastsFlickerWithThreeProcessesLikeThirteen) {
  for (const double instability : {1e-4, 4e-4, 8e-4, 2e-3, 5e-3}) {
    BiasNoise noise = virtual_noise();
    noise.instability_deg_per_h = instability;
    const Mismatch truth = make_flicker(instability, noise, 13);
    const StateSpace space = state_space(noise, kInterval_s);
    const double best = forecast_error(truth, truth);
    const double own = forecast_error(truth, {space.memory, space.fresh, space.start, space.white});
    EXPECT_GE(own, best * (1 - 1e-9)) << "no model is better than the true one";
    EXPECT_LT(own, 1.01 * best) << instability;
  }
}

TEST(StateSpace, SimulatesItsOwnCovariance) {
  BiasNoise noise = virtual_noise();
  noise.instability_deg_per_h = 2e-3;
  const StateSpace space = state_space(noise, kInterval_s);
  const Eigen::MatrixXd expected = covariance_of_bias(space, 40);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(40, 40);
  double white = 0;
  std::mt19937_64 random(1);
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    const DrawnBias drawn = draw(space, 40, random);
    sum += drawn.bias_deg_per_h * drawn.bias_deg_per_h.transpose();
    white += (drawn.measured_deg_per_h - drawn.bias_deg_per_h).squaredNorm();
  }
  EXPECT_LT((sum / kDraws - expected).cwiseAbs().maxCoeff(), 5 * std::sqrt(2.0 / kDraws) * expected.maxCoeff());
  EXPECT_NEAR(white / kDraws / 40, space.white, 5 * std::sqrt(2.0 / kDraws / 40) * space.white);
}

TEST(SteadyState, MatchesClosedFormForRandomWalk) {
  BiasNoise noise = virtual_noise();
  noise.instability_deg_per_h = 0;
  for (const double walk : {1e-5, 6e-5, 1e-3, 0.1}) {
    noise.rate_random_walk_deg_per_h_per_sqrt_h = walk;
    const StateSpace space = state_space(noise, kInterval_s);
    const double q = space.fresh(0), r = space.white, p = q / 2 + std::sqrt(q * q / 4 + q * r);
    EXPECT_NEAR(steady_state(space).predicted(0, 0), p, 1e-10 * p);
    EXPECT_NEAR(steady_state(space).gain(0), p / (p + r), 1e-10);
  }
}

TEST(SteadyState, MatchesConvergedFilter) {
  for (const double instability : {0.0, 4e-4, 5e-3}) {
    BiasNoise noise = virtual_noise();
    noise.instability_deg_per_h = instability;
    // A large random walk lets the filter settle quickly.
    noise.rate_random_walk_deg_per_h_per_sqrt_h = 1e-3;
    const StateSpace space = state_space(noise, kInterval_s);
    const Covariance last = track(space, Eigen::VectorXd::Zero(50000)).back().predicted_covariance;
    const SteadyState steady = steady_state(space);
    EXPECT_LT((steady.predicted - last).cwiseAbs().maxCoeff(), 1e-9 * last.maxCoeff()) << instability;
    const State gain = last.rowwise().sum() / (last.sum() + space.white);
    EXPECT_LT((steady.gain - gain).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(SteadyState, HasNoGainForConstantBias) {
  BiasNoise noise = virtual_noise();
  noise.rate_random_walk_deg_per_h_per_sqrt_h = 0;
  EXPECT_NEAR(steady_state(state_space(noise, kInterval_s)).gain(0), 0, 1e-15);
  EXPECT_GT(steady_state(state_space(noise, kInterval_s)).gain(1), 0) << "the flicker is still tracked";
  noise.instability_deg_per_h = 0;
  EXPECT_EQ(steady_state(state_space(noise, kInterval_s)).gain, State::Zero());
}

}  // namespace
}  // namespace gyrotherm::tracking
