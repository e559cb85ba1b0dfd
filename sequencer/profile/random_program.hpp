/// Draws the steps of a random program: the same ones from the same seed on every machine.
#pragma once

#include <cstddef>
#include <optional>
#include <random>

#include "sequencer/profile/written_profile.hpp"

namespace gyrotherm {

/// A ramp to a target, and the hold there.
struct RandomStep {
  Celsius to;
  CelsiusPerMinute rate;
  Duration hold{};
};

/// Targets are drawn uniformly from the rows in turn, in steps of 0.1 °C; rates in steps of 0.01 °C/min; holds in whole
/// seconds.
class RandomProgram {
 public:
  explicit RandomProgram(const WrittenRandom& program) : program_(program), engine_(program.seed) {}

  /// The next step from a set point. Nothing if the next row has no target that is `least_step` away from it.
  [[nodiscard]] std::optional<RandomStep> next(Celsius from);

 private:
  /// Uniform over [low, high], rounded to `per_unit` values in one unit.
  double draw(double low, double high, double per_unit);
  std::optional<Celsius> draw_target(Celsius from);

  const WrittenRandom& program_;
  std::mt19937_64 engine_;
  std::size_t row_ = 0;
};

}  // namespace gyrotherm
