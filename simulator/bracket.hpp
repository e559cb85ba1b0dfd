// SPDX-License-Identifier: Apache-2.0
/// A bracket on which several bodies stand in the chamber's air, and heat each other.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm::simulator {

/// [[virtual.bracket]]: `share` of each cabinet's film goes to the bracket, the rest to the air. The bracket gives heat
/// to nothing else, so that it follows the mean of the cabinets, and what one body loses to it the others gain: with
/// equal films hA of n bodies, time_constant_s is its heat capacity over n · share · hA.
struct BracketParameters {
  std::vector<std::size_t> units;  ///< by index; all axes of a unit stand on it
  double share{};                  ///< 0 … kMostBracketShare
  double time_constant_s = 1;      ///< 1 or more
};

/// So that there is a rest: all of the film to the bracket would leave the heat no way to the air.
inline constexpr double kMostBracketShare = 0.9;

class Bracket {
 public:
  Bracket(const BracketParameters& parameters, Celsius start);

  /// What a body on it takes for the chamber's air: air + share · (bracket − air).
  [[nodiscard]] Celsius seen_by_a_body(Celsius air) const;
  /// One second on, the mean of the cabinets is here.
  void follow(Celsius cabinets);
  [[nodiscard]] Celsius temperature() const { return at_; }

 private:
  double share_;
  double closes_;  ///< share of the difference that a second closes
  Celsius at_;
};

/// Where a bracket rests in air of this temperature. `cabinets` tells where its bodies' cabinets rest, on the mean,
/// while each sees this for its air.
[[nodiscard]] Celsius bracket_at_rest(double share, Celsius air, const std::function<Celsius(Celsius)>& cabinets);

}  // namespace gyrotherm::simulator
