#include "thermal/reduced/step_table.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "thermal/reduced/thermal_modes.hpp"

namespace gyrotherm {
namespace {

// The coefficients are analytic inside the ellipse through −273 °C, of parameter ρ = 5.9: error about ρ^−17.
constexpr Eigen::Index kNodes = 18;

/// Values at `x` of the polynomials that are 1 at one node and 0 at the others.
Eigen::VectorXd cardinal(const Eigen::VectorXd& nodes, const Eigen::VectorXd& weights, double x) {
  Eigen::VectorXd values = Eigen::VectorXd::Zero(nodes.size());
  for (Eigen::Index i = 0; i < nodes.size(); ++i) {
    if (x == nodes[i]) return Eigen::VectorXd::Unit(nodes.size(), i);
    values[i] = weights[i] / (x - nodes[i]);
  }
  return values / values.sum();
}

}  // namespace

StepTable::StepTable(const ReducedModel& model, GyroFilm film) : nodes_c_(kNodes), weights_(kNodes) {
  const auto states = model.conduction.rows();
  table_.resize(states * states + 3 * states, kNodes);
  for (Eigen::Index i = 0; i < kNodes; ++i) {
    const double angle = (2.0 * static_cast<double>(i) + 1) * std::numbers::pi / (2.0 * kNodes);
    nodes_c_[i] =
        (kColdestGapAir_c + kHottestGapAir_c) / 2 + (kHottestGapAir_c - kColdestGapAir_c) / 2 * std::cos(angle);
    weights_[i] = (i % 2 == 0 ? 1 : -1) * std::sin(angle);
    const auto second = one_second(model, coefficients_at(model, nodes_c_[i], film));
    table_.col(i) << second.carry.reshaped(), second.before, second.after, second.powers;
  }
  next_.resize(states);
}

void StepTable::update(double air_c) {
  now_.noalias() = table_ * cardinal(nodes_c_, weights_, std::clamp(air_c, kColdestGapAir_c, kHottestGapAir_c));
}

void StepTable::step(Eigen::VectorXd& states, double from_c, double to_c) {
  assert(now_.size() > 0);
  const auto r = states.size();
  const Eigen::Map<const Eigen::MatrixXd> carry(now_.data(), r, r);
  const Eigen::Map<const Eigen::MatrixXd> inputs(now_.data() + r * r, r, 3);
  next_ = inputs.col(0) * from_c + inputs.col(1) * to_c + inputs.col(2);
  next_.noalias() += carry * states;
  states.swap(next_);
}

}  // namespace gyrotherm
