// SPDX-License-Identifier: Apache-2.0
#include "simulator/slow_bias.hpp"

#include <cmath>
#include <utility>

namespace gyrotherm::simulator {

double closes_in_a_second(double time_constant_s) { return -std::expm1(-1 / time_constant_s); }

LaggingPart::LaggingPart(const HiddenLag& lag) : lag_(lag), closes_(closes_in_a_second(lag.time_constant_s)) {}

double LaggingPart::follow(double now) {
  if (!std::exchange(began_, true)) lagged_ = now;
  lagged_ += closes_ * (now - lagged_);
  return now + lag_.share * (lagged_ - now);
}

RelaxingBias::RelaxingBias(const std::vector<Relaxation>& terms, double start_c) {
  for (const auto& term : terms)
    terms_.push_back({term.deg_per_h_per_k, closes_in_a_second(term.time_constant_s), start_c});
}

void RelaxingBias::follow(double now_c) {
  deg_per_h_ = 0;
  for (auto& term : terms_) {
    term.relaxed_c += term.closes * (now_c - term.relaxed_c);
    deg_per_h_ += term.deg_per_h_per_k * (now_c - term.relaxed_c);
  }
}

double warm_up_deg_per_h(const std::vector<WarmUp>& phases, double seconds_on) {
  double sum = 0;
  for (const auto& phase : phases) sum += phase.deg_per_h * std::exp(-seconds_on / phase.time_constant_s);
  return sum;
}

}  // namespace gyrotherm::simulator
