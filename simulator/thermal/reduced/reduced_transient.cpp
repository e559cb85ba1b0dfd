// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/reduced/reduced_transient.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

namespace gyrotherm::thermal {
namespace {

// The coefficients are analytic inside the ellipse through −273 °C with parameter ρ = 5.9: error about ρ^−17.
constexpr Eigen::Index kNodes = 18;

/// Returns the values at `x` of the polynomials that are 1 at one node and 0 at all others.
Eigen::VectorXd cardinal(const Eigen::VectorXd& nodes, const Eigen::VectorXd& weights, double x) {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(nodes.size());
  for (Eigen::Index i = 0; i < nodes.size(); ++i) {
    if (x == nodes[i]) return Eigen::VectorXd::Unit(nodes.size(), i);
    values[i] = weights[i] / (x - nodes[i]);
  }
  return values / values.sum();
}

Eigen::Map<const Eigen::VectorXd> as_vector(std::span<const double> values) {
  return {values.data(), std::ssize(values)};
}

Eigen::VectorXd initial_states(const ReducedModel& model, const ReducedTransientOptions& options) {
  const double air_c = options.start.value;
  if (options.cold) return cold_states_at_rest(model, options.film, air_c);
  if (options.added_w) return states_at_rest(add_powers(model, *options.added_w), options.film, air_c);
  return states_at_rest(model, options.film, air_c);
}

}  // namespace

ThermalModes compute_modes(const ReducedModel& model, const ThermalCoefficients& c) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(conduction_at(model, c));
  assert(eigen.info() == Eigen::Success && eigen.eigenvalues()[0] > 0);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

ModalWeights modal_weights(const Eigen::VectorXd& rates_per_s, double step_s) {
  // Below this limit the closed form loses more digits than the truncated series.
  constexpr double kSeries = 1e-3;
  ModalWeights w{Eigen::ArrayXd(rates_per_s.size()), Eigen::ArrayXd(rates_per_s.size()),
                 Eigen::ArrayXd(rates_per_s.size())};
  for (Eigen::Index i = 0; i < rates_per_s.size(); ++i) {
    const double z = rates_per_s[i] * step_s;
    const double lost = -std::expm1(-z);
    w.decay[i] = std::exp(-z);
    w.after[i] =
        z < kSeries ? step_s * (1.0 / 2 - z * (1.0 / 6 - z * (1.0 / 24 - z / 120))) : step_s * (1 - lost / z) / z;
    w.before[i] = step_s * lost / z - w.after[i];
  }
  return w;
}

ModalSecond::ModalSecond(const ReducedModel& model, const ThermalCoefficients& c) {
  auto modes = compute_modes(model, c);
  const auto weights = modal_weights(modes.rates_per_s, 1);
  const Eigen::MatrixXd inputs = modes.shapes.transpose() * inputs_at(model, c);
  decay = weights.decay;
  before = weights.before * inputs.col(0).array();
  after = weights.after * inputs.col(0).array();
  powers = (weights.before + weights.after) * (inputs * operating_inputs(model, 0)).array();
  per_watt = (weights.before + weights.after).matrix().asDiagonal() * inputs.rightCols(inputs.cols() - 1);
  shapes = std::move(modes.shapes);
}

void ModalSecond::step(Eigen::VectorXd& amplitudes, double from_c, double to_c, std::span<const double> added_w,
                       bool on) const {
  amplitudes.array() = decay * amplitudes.array() + before * from_c + after * to_c;
  if (on) amplitudes.array() += powers;
  if (!added_w.empty()) amplitudes.noalias() += per_watt * as_vector(added_w);
}

OneSecond one_second(const ReducedModel& model, const ThermalCoefficients& c) {
  const ModalSecond modal(model, c);
  return {.carry = modal.shapes * modal.decay.matrix().asDiagonal() * modal.shapes.transpose(),
          .before = modal.shapes * modal.before.matrix(),
          .after = modal.shapes * modal.after.matrix(),
          .powers = modal.shapes * modal.powers.matrix(),
          .per_watt = modal.shapes * modal.per_watt};
}

StepTable::StepTable(const ReducedModel& model, GyroFilm film, bool powers_vary) : nodes_c_(kNodes), weights_(kNodes) {
  const auto states = model.conduction.rows();
  const auto powers = powers_vary ? model.inputs.cols() - 1 : 0;
  table_.resize(states * states + (3 + powers) * states, kNodes);
  for (Eigen::Index i = 0; i < kNodes; ++i) {
    const double angle = (2.0 * static_cast<double>(i) + 1) * std::numbers::pi / (2.0 * kNodes);
    nodes_c_[i] =
        (kColdestGapAir_c + kHottestGapAir_c) / 2 + (kHottestGapAir_c - kColdestGapAir_c) / 2 * std::cos(angle);
    weights_[i] = (i % 2 == 0 ? 1 : -1) * std::sin(angle);
    const auto second = one_second(model, coefficients_at(model, nodes_c_[i], film));
    table_.col(i) << second.carry.reshaped(), second.before, second.after, second.powers,
        second.per_watt.leftCols(powers).reshaped();
  }
  next_.resize(states);
}

void StepTable::update(double air_c) {
  now_.noalias() = table_ * cardinal(nodes_c_, weights_, std::clamp(air_c, kColdestGapAir_c, kHottestGapAir_c));
}

void StepTable::step(Eigen::VectorXd& states, double from_c, double to_c, std::span<const double> added_w, bool on) {
  assert(now_.size() > 0);
  const auto r = states.size();
  const Eigen::Map<const Eigen::MatrixXd> carry(now_.data(), r, r);
  const Eigen::Map<const Eigen::MatrixXd> inputs(now_.data() + r * r, r, 3);
  next_ = inputs.col(0) * from_c + inputs.col(1) * to_c;
  if (on) next_ += inputs.col(2);
  next_.noalias() += carry * states;
  if (!added_w.empty()) {
    const auto powers = std::ssize(added_w);
    assert(now_.size() == r * r + (3 + powers) * r);
    next_.noalias() += Eigen::Map<const Eigen::MatrixXd>(now_.data() + r * r + 3 * r, r, powers) * as_vector(added_w);
  }
  states.swap(next_);
}

double gap_air_c(const Eigen::Ref<const Eigen::VectorXd>& outputs_c) {
  return (outputs_c[static_cast<Eigen::Index>(ThermalOutput::block)] +
          outputs_c[static_cast<Eigen::Index>(ThermalOutput::shell)]) /
         2;
}

Eigen::VectorXd states_at_rest(const ReducedModel& model, GyroFilm film, double air_c) {
  constexpr int kMostRounds = 100;
  constexpr double kSettled_k = 1e-10;
  double gap_c = air_c;
  Eigen::VectorXd states;
  for (int round = 0; round < kMostRounds; ++round) {
    states = states_at(model, coefficients_at(model, gap_c, film), 0) * operating_inputs(model, air_c);
    const double next_c = gap_air_c(model.outputs * states);
    if (std::abs(next_c - gap_c) <= kSettled_k) break;
    gap_c = next_c;
  }
  return states;
}

ReducedModel add_powers(ReducedModel model, const ThermalPowers& added_w) {
  for (std::size_t i = 0; i < added_w.size(); ++i) model.powers_w[i] += added_w[i];
  return model;
}

Eigen::VectorXd cold_states_at_rest(const ReducedModel& model, GyroFilm film, double air_c) {
  auto inputs = operating_inputs(model, air_c);
  inputs.tail(inputs.size() - 1).setZero();
  return states_at(model, coefficients_at(model, air_c, film), 0) * inputs;
}

std::variant<ModalSecond, StepTable> ReducedTransient::make_stepper(const ReducedModel& model) {
  if (!options_.linear) return StepTable(model, options_.film, options_.added_w.has_value());
  ModalSecond modal(model, coefficients_at(model, gap_air_c(outputs_ * states_), options_.film));
  states_ = (modal.shapes.transpose() * states_).eval();
  outputs_ = (outputs_ * modal.shapes).eval();
  return modal;
}

ReducedTransient::ReducedTransient(const ReducedModel& model, const ReducedTransientOptions& options)
    : options_(options),
      air_c_(options.start.value),
      states_(initial_states(model, options)),
      outputs_(model.outputs),
      stepper_(make_stepper(model)),
      outputs_c_(outputs_ * states_) {
  assert(options.seconds_per_update >= 1);
}

void ReducedTransient::step(Celsius air, std::span<const double> added_w) {
  assert(added_w.empty() || (options_.added_w && added_w.size() == options_.added_w->size()));
  if (auto* table = std::get_if<StepTable>(&stepper_)) {
    if (seconds_ % options_.seconds_per_update == 0) table->update(gap_air_c(outputs_c_));
    table->step(states_, air_c_, air.value, added_w, on_);
  } else {
    std::get<ModalSecond>(stepper_).step(states_, air_c_, air.value, added_w, on_);
  }
  air_c_ = air.value;
  ++seconds_;
  outputs_c_.noalias() = outputs_ * states_;
}

std::span<const double, kThermalOutputs> ReducedTransient::outputs_c() const {
  return std::span<const double, kThermalOutputs>(outputs_c_.data(), kThermalOutputs);
}

}  // namespace gyrotherm::thermal
