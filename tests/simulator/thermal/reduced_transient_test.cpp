// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/reduced/reduced_transient.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstring>
#include <random>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "simulator/thermal/model_order_reduction_error.hpp"
#include "tests/simulator/thermal/small_bodies.hpp"

namespace gyrotherm::thermal {
namespace {

constexpr unsigned kReducedSeed = 61;

/// Computes the step of one second from the matrix exponential of the system, extended by its inputs as ramps.
OneSecond matrix_exponential_step(const ReducedModel& model, const ThermalCoefficients& c) {
  const auto r = model.conduction.rows();
  Eigen::MatrixXd inputs(r, 2);
  inputs << inputs_at(model, c).col(0), inputs_at(model, c) * operating_inputs(model, 0);
  Eigen::MatrixXd extended = Eigen::MatrixXd::Zero(r + 4, r + 4);
  extended.topLeftCorner(r, r) = -conduction_at(model, c);
  extended.block(0, r, r, 2) = inputs;
  extended.block(r, r + 2, 2, 2).setIdentity();
  const Eigen::MatrixXd e = extended.exp();
  return {e.topLeftCorner(r, r), e.col(r) - e.col(r + 2), e.col(r + 2), e.col(r + 1).head(r)};
}

void expect_near(const OneSecond& a, const OneSecond& b, double tolerance) {
  const auto r = a.carry.rows();
  EXPECT_LE((a.carry - b.carry).cwiseAbs().maxCoeff(), tolerance);
  const auto scale = [&](const auto& v) { return std::max(1.0, v.cwiseAbs().maxCoeff()); };
  EXPECT_LE((a.before - b.before.head(r)).cwiseAbs().maxCoeff(), tolerance * scale(a.before));
  EXPECT_LE((a.after - b.after.head(r)).cwiseAbs().maxCoeff(), tolerance * scale(a.after));
  EXPECT_LE((a.powers - b.powers.head(r)).cwiseAbs().maxCoeff(), tolerance * scale(a.powers));
}

/// Returns the air temperature of a short program with ramps of several rates between −40 and 60 °C.
double program_c(int second) {
  const double t = second % 9000;
  if (t < 600) return 20 + t / 15;
  if (t < 2400) return 60;
  return t < 8400 ? 60 - (t - 2400) / 60 : -40 + (t - 8400) / 10;
}

TEST(ModalWeights, AgreeOnBothSidesOfSeries) {
  Eigen::VectorXd rates(6);
  rates << 1e-12, 1e-6, 9.999e-4, 1.0001e-3, 0.5, 80;
  const auto w = modal_weights(rates, 1);
  for (Eigen::Index i = 0; i < rates.size(); ++i) {
    const long double z = rates[i];
    const long double lost = -std::expm1(-z);
    const long double after = z < 1e-5L ? 0.5L - z / 6 : (1 - lost / z) / z;
    EXPECT_NEAR(w.after[i], static_cast<double>(after), 1e-13);
    EXPECT_NEAR(w.before[i] + w.after[i], static_cast<double>(lost / z), 1e-15);
    EXPECT_NEAR(w.decay[i], static_cast<double>(std::exp(-z)), 1e-15);
  }
}

TEST(OneSecond, EqualsMatrixExponential) {
  const auto& model = reduced_box_gyro();
  for (const double air_c : {-40.0, 20.0, 60.0}) {
    const auto c = coefficients_at(model, air_c, GyroFilm::chamber);
    expect_near(one_second(model, c), matrix_exponential_step(model, c), 1e-11);
  }
}

TEST(StepTable, MatchesStepAtAnyTemperature) {
  const auto& model = reduced_box_gyro();
  StepTable table(model, GyroFilm::chamber);
  std::mt19937_64 random(kReducedSeed);
  std::uniform_real_distribution<double> anywhere(-80, 130);
  for (int i = 0; i < 20; ++i) {
    const double air_c = anywhere(random);
    SCOPED_TRACE(fmt::format("seed {}: {} °C", kReducedSeed, air_c));
    const auto second = one_second(model, coefficients_at(model, air_c, GyroFilm::chamber));
    Eigen::VectorXd states = Eigen::VectorXd::LinSpaced(model.conduction.rows(), -30, 50);
    const Eigen::VectorXd expected = second.carry * states + second.before * 17 + second.after * 18 + second.powers;
    table.update(air_c);
    table.step(states, 17, 18);
    EXPECT_LE((states - expected).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(ReducedTransient, StaysAtRest) {
  for (const bool linear : {true, false}) {
    ReducedTransient reduced(reduced_box_gyro(), {.start = {-15}, .linear = linear});
    const std::vector<double> start(reduced.outputs_c().begin(), reduced.outputs_c().end());
    for (int i = 0; i < 20000; ++i) reduced.step({-15});
    for (std::size_t i = 0; i < start.size(); ++i) EXPECT_NEAR(reduced.outputs_c()[i], start[i], 1e-8);
  }
}

/// Powers that are added in every step have the same effect as a model with larger powers.
TEST(ReducedTransient, AcceptsAddedPowers) {
  constexpr ThermalPowers kAddedW{0.1, -0.05, 0.2, 0.03, -0.01};
  const auto more = add_powers(reduced_box_gyro(), kAddedW);
  for (const bool linear : {true, false}) {
    ReducedTransient added(reduced_box_gyro(), {.start = {-15}, .added_w = kAddedW, .linear = linear});
    ReducedTransient own(more, {.start = {-15}, .linear = linear});
    for (int i = 0; i < 3000; ++i) {
      for (std::size_t j = 0; j < kThermalOutputs; ++j)
        ASSERT_NEAR(added.outputs_c()[j], own.outputs_c()[j], 1e-8) << i;
      added.step({program_c(i)}, kAddedW);
      own.step({program_c(i)});
    }
  }
}

// Adds 1 W to one input for one second.
TEST(ReducedTransient, RecoversAfterPulse) {
  ReducedTransient pulsed(reduced_box_gyro(), {.start = {20}, .added_w = ThermalPowers{}});
  const double rest_c = pulsed.outputs_c()[0];
  pulsed.step({20}, ThermalPowers{100, 0, 0, 0, 0});
  for (int i = 0; i < 300; ++i) pulsed.step({20}, ThermalPowers{});
  const double soon_k = pulsed.outputs_c()[0] - rest_c;
  EXPECT_GT(soon_k, 1e-3);
  for (int i = 0; i < 40000; ++i) pulsed.step({20}, ThermalPowers{});
  EXPECT_NEAR(pulsed.outputs_c()[0], rest_c, 0.1 * soon_k);
}

TEST(ReducedTransient, LinearStepsMatchMatrixExponential) {
  const auto& model = reduced_box_gyro();
  Eigen::VectorXd states = states_at_rest(model, GyroFilm::still, 20);
  const auto c = coefficients_at(model, gap_air_c(model.outputs * states), GyroFilm::still);
  const auto second = matrix_exponential_step(model, c);
  const auto r = states.size();
  ReducedTransient reduced(model, {.film = GyroFilm::still, .linear = true});
  for (int i = 1; i <= 9000; ++i) {
    states = (second.carry * states + second.before.head(r) * program_c(i - 1) + second.after.head(r) * program_c(i) +
              second.powers)
                 .eval();
    reduced.step({program_c(i)});
    const Eigen::VectorXd expected = model.outputs * states;
    for (std::size_t j = 0; j < kThermalOutputs; ++j)
      ASSERT_NEAR(reduced.outputs_c()[j], expected[static_cast<Eigen::Index>(j)], 1e-8) << i;
  }
}

/// Compares with another method of integration, which computes new modes at each update and converts the state from the
/// old modes to the new ones.
TEST(ReducedTransient, MatchesModalIntegration) {
  const auto& model = reduced_box_gyro();
  Eigen::VectorXd outputs = model.outputs * states_at_rest(model, GyroFilm::chamber, 20);
  auto modes = compute_modes(model, coefficients_at(model, 20, GyroFilm::chamber));
  Eigen::VectorXd amplitudes = modes.shapes.transpose() * states_at_rest(model, GyroFilm::chamber, 20);
  ReducedTransient reduced(model, {});
  ModalWeights weights;
  Eigen::MatrixXd inputs;
  for (int i = 1; i <= 9000; ++i) {
    const auto c = coefficients_at(model, gap_air_c(outputs), GyroFilm::chamber);
    if ((i - 1) % 10 == 0) {
      const auto next = compute_modes(model, c);
      amplitudes = (next.shapes.transpose() * (modes.shapes * amplitudes)).eval();
      modes = next;
      weights = modal_weights(modes.rates_per_s, 1);
      inputs = modes.shapes.transpose() * inputs_at(model, c);
    }
    const Eigen::ArrayXd from = inputs * operating_inputs(model, program_c(i - 1));
    const Eigen::ArrayXd to = inputs * operating_inputs(model, program_c(i));
    amplitudes = (weights.decay * amplitudes.array() + weights.before * from + weights.after * to).matrix();
    outputs = model.outputs * (modes.shapes * amplitudes);
    reduced.step({program_c(i)});
    for (std::size_t j = 0; j < kThermalOutputs; ++j)
      ASSERT_NEAR(reduced.outputs_c()[j], outputs[static_cast<Eigen::Index>(j)], 1e-7) << i;
  }
}

TEST(ReducedTransient, IsReproducible) {
  for (const bool linear : {true, false}) {
    ReducedTransient one(reduced_box_gyro(), {.linear = linear});
    ReducedTransient other(reduced_box_gyro(), {.linear = linear});
    for (int i = 1; i <= 3000; ++i) {
      one.step({program_c(i)});
      other.step({program_c(i)});
      ASSERT_EQ(std::memcmp(one.outputs_c().data(), other.outputs_c().data(), sizeof(double) * kThermalOutputs), 0)
          << i;
    }
  }
}

TEST(ReducedTransient, ConductsBetterInWarmAir) {
  ReducedTransient constant(reduced_box_gyro(), {.start = {-40}, .linear = true});
  ReducedTransient following(reduced_box_gyro(), {.start = {-40}});
  for (int i = 0; i < 100000; ++i) {
    constant.step({60});
    following.step({60});
  }
  EXPECT_GT(constant.outputs_c()[0], following.outputs_c()[0] + 0.5);
}

/// Returns the largest difference between the outputs of the full model, integrated by the trapezoidal rule, and those
/// of its twin.
double largest_difference(const ThermalSystem& system, const ReducedModel& model, double step_s) {
  const auto c = coefficients_at(model, gap_air_c(model.outputs * states_at_rest(model, GyroFilm::chamber, 20)),
                                 GyroFilm::chamber);
  AffineMatrix matrices(system);
  auto above = direct_solver()(matrices.sum(0, 1, c), system.inputs * operating_inputs(model, 0));
  FullTransient full(system, (above->col(0).array() + 20).matrix());
  EXPECT_TRUE(full.set(step_s, c));
  ReducedTransient reduced(model, {.linear = true});
  double largest = 0;
  for (int second = 0; second < 1800;) {
    const double from = program_c(second);
    for (int i = 0; i < static_cast<int>(step_s); ++i) reduced.step({program_c(++second)});
    EXPECT_TRUE(full.step(operating_inputs(model, from), operating_inputs(model, program_c(second))));
    const Eigen::VectorXd outputs = full.outputs_c();
    for (std::size_t j = 0; j < kThermalOutputs; ++j)
      largest = std::max(largest, std::abs(outputs[static_cast<Eigen::Index>(j)] - reduced.outputs_c()[j]));
  }
  return largest;
}

TEST(FullTransient, ConvergesWithSquareOfStep) {
  const auto system = box_gyro();
  const double coarse = largest_difference(system, reduced_box_gyro(), 40);
  const double fine = largest_difference(system, reduced_box_gyro(), 20);
  EXPECT_GT(coarse, 1e-3);
  EXPECT_NEAR(coarse / fine, 4, 1.2);
}

/// Returns the largest difference of the outputs after the first minute, if all powers are switched on at the same
/// time.
double difference_after_jump(const ThermalSystem& system, const ReducedModel& model, int step_s) {
  const auto c = coefficients_at(model, 20, GyroFilm::chamber);
  const auto second = one_second(model, c);
  const auto on = operating_inputs(model, 20);
  Eigen::VectorXd states = states_at(model, c, 0).col(0) * 20;
  FullTransient full(system, Eigen::VectorXd::Constant(system.capacity.rows(), 20));
  EXPECT_TRUE(full.set(step_s, c));
  EXPECT_TRUE(full.damped_step(on, on));
  double largest = 0;
  for (int t = 1; t <= 1200; ++t) {
    states = (second.carry * states + (second.before + second.after) * 20 + second.powers).eval();
    if (t % step_s != 0) continue;
    if (t > step_s) {
      EXPECT_TRUE(full.step(on, on));
    }
    if (t >= 60) largest = std::max(largest, (full.outputs_c() - model.outputs * states).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(FullTransient, KeepsOrderAfterJump) {
  const auto system = box_gyro();
  const double coarse = difference_after_jump(system, reduced_box_gyro(), 20);
  const double fine = difference_after_jump(system, reduced_box_gyro(), 10);
  EXPECT_GT(coarse, 1e-4);
  EXPECT_GT(coarse / fine, 3);
}

}  // namespace
}  // namespace gyrotherm::thermal
