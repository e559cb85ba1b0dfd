// SPDX-License-Identifier: Apache-2.0
#include "simulator/bracket.hpp"

#include <cassert>
#include <cmath>

namespace gyrotherm::simulator {
namespace {

Celsius mixed(double share, Celsius air, Celsius bracket) { return {air.value + share * (bracket.value - air.value)}; }

}  // namespace

Bracket::Bracket(const BracketParameters& parameters, Celsius start)
    : share_(parameters.share), closes_(-std::expm1(-1 / parameters.time_constant_s)), at_(start) {
  assert(0 <= share_ && share_ <= kMostBracketShare && parameters.time_constant_s >= 1);
}

Celsius Bracket::seen_by_a_body(Celsius air) const { return mixed(share_, air, at_); }

void Bracket::follow(Celsius cabinets) { at_.value += closes_ * (cabinets.value - at_.value); }

Celsius bracket_at_rest(double share, Celsius air, const std::function<Celsius(Celsius)>& cabinets) {
  constexpr int kMostRounds = 50;
  constexpr double kSettledK = 1e-10;
  Celsius bracket = air;
  for (int round = 0; round < kMostRounds; ++round) {
    // By how much a cabinet is above what it sees hardly depends on that: each round is a hundred times nearer.
    const auto seen = mixed(share, air, bracket);
    const double above_k = (cabinets(seen).value - seen.value) / (1 - share);
    const double step_k = air.value + above_k - bracket.value;
    bracket.value += step_k;
    if (std::abs(step_k) <= kSettledK) break;
  }
  return bracket;
}

}  // namespace gyrotherm::simulator
